"""Settings of the speech service, from the environment (prefix SPEECH_)."""

from enum import StrEnum

from pydantic import Field
from pydantic_settings import SettingsConfigDict

from mesh.settings import Port, ServiceSettings


class VoiceEngine(StrEnum):
    """Who speaks."""

    HIBARI = "hibari"
    """In this process, from its wheel: American English, one voice."""
    ESPEAK = "espeak"
    """espeak-ng as a child process: many languages, robotic."""


class Settings(ServiceSettings):
    """Frozen; every number carries its unit in its name."""

    model_config = SettingsConfigDict(env_prefix="SPEECH_", frozen=True, protected_namespaces=())

    port: Port = 8005
    whisper_model: str = Field(
        default="",
        description="a folder of CTranslate2 files, or a name where it is cached; empty = tiny.en of a wheel",
    )
    whisper_download: bool = Field(default=False, description="a model given by name may be fetched from the internet")
    language: str = Field(default="en", max_length=16, description="of what is said; empty = the model finds out")
    voice_engines: tuple[VoiceEngine, ...] = Field(
        default=(VoiceEngine.HIBARI, VoiceEngine.ESPEAK), description="in the order in which they are preferred"
    )
    threads: int = Field(default=2, ge=1, le=64, description="of the recogniser")
    waiting_max: int = Field(default=4, ge=1, le=64, description="calls that may wait or run; one more gets 503")
    listeners_max: int = Field(default=4, ge=1, le=64, description="open sockets; one more is closed with 1013")
    partial_period_s: float = Field(default=0.5, ge=0.3, le=5.0, description="between two partial readings")
    log_text: bool = Field(default=False, description="what was heard and said stands in the log; else only how much")
