"""Settings of the ear, from the environment (prefix EAR_)."""

from enum import StrEnum
from pathlib import Path
from typing import Final

from pydantic import Field, field_validator
from pydantic_settings import SettingsConfigDict

from ear.quiet_hours import QuietHours
from mesh.settings import ClientSettings

MICROPHONE: Final = "microphone"
STANDARD_INPUT: Final = "-"
NONE: Final = "none"


class WakeWord(StrEnum):
    """The words that `pyopen-wakeword` carries."""

    HEY_JARVIS = "hey_jarvis"
    OKAY_NABU = "okay_nabu"
    ALEXA = "alexa"
    HEY_MYCROFT = "hey_mycroft"
    HEY_RHASSPY = "hey_rhasspy"


class Settings(ClientSettings):
    """Frozen; every number carries its unit in its name."""

    model_config = SettingsConfigDict(env_prefix="EAR_", frozen=True)

    coordinator_url: str = Field(default="http://127.0.0.1:8001", description="of the coordinator")
    memory_url: str = Field(default="http://127.0.0.1:8003", description="of memory: names to expect; empty = none")
    robot_bridge_url: str = Field(default="http://127.0.0.1:8004", description="of the bridge to the robot")
    speech_url: str = Field(default="http://127.0.0.1:8005", description="of the speech service")
    sound: str = Field(
        default=MICROPHONE,
        min_length=1,
        max_length=500,
        description="what it listens to: `microphone`, a WAV file (16 kHz, one channel), or `-` = raw 16 kHz 16-bit "
        "samples on standard input",
    )
    microphone: str = Field(default="", max_length=200, description="its name, or part of it; empty = the usual one")
    loudspeaker: str = Field(default="", max_length=200, description="the same; `none` = it never speaks")
    voice: str = Field(default="", max_length=64, description="as speech's `GET /voices` names it; empty = the first")
    wake_word: WakeWord = Field(default=WakeWord.HEY_JARVIS, description="the word that wakes it")
    wake_probability_min: float = Field(default=0.5, gt=0.0, lt=1.0, description="from here on it was said")
    stop_without_wake_word: bool = Field(
        default=True, description="while the robot may move, short sayings are read for an order to stop"
    )
    quiet_hours: str = Field(
        default="", description="it says nothing, as 22:00-07:00 in the machine's time zone; it hears and stops as ever"
    )
    hold_s: float = Field(
        default=30.0, ge=5.0, le=60.0, description="a mission stands for it, asked for anew; then it goes on by itself"
    )
    call_timeout_s: float = Field(default=5.0, gt=0.0, description="of an ordinary call")
    command_timeout_s: float = Field(default=30.0, gt=0.0, description="reading a command may ask a language model")
    speak_timeout_s: float = Field(default=15.0, gt=0.0, description="for a sentence to be made")
    stop_timeout_s: float = Field(default=1.5, gt=0.0, description="of one try")

    @field_validator("quiet_hours")
    @classmethod
    def _is_a_stretch_of_the_day(cls, written: str) -> str:
        QuietHours.read(written)
        return written

    @field_validator("sound")
    @classmethod
    def _is_there(cls, named: str) -> str:
        if named not in {MICROPHONE, STANDARD_INPUT} and not Path(named).is_file():
            raise ValueError(f"no file {named}; `microphone`, or `-` for standard input")
        return named
