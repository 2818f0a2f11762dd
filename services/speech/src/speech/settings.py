"""Settings of the speech service, from the environment (prefix SPEECH_)."""

from enum import StrEnum

from pydantic import Field, SecretStr
from pydantic_settings import SettingsConfigDict

from mesh.settings import Port, ServiceSettings


class RecognizerEngine(StrEnum):
    """Who reads what was said. One alone: where it is away that is said, and no other takes its place."""

    WHISPER = "whisper"
    """faster-whisper in this process."""
    OPENAI = "openai"
    """A server with OpenAI's /v1/audio/transcriptions."""
    WYOMING = "wyoming"
    """A server of Home Assistant's protocol."""


class VoiceEngine(StrEnum):
    """Who speaks."""

    HIBARI = "hibari"
    """In this process, from its wheel: American English, one voice."""
    ESPEAK = "espeak"
    """espeak-ng as a child process: many languages, robotic."""
    WYOMING = "wyoming"
    """A server of Home Assistant's protocol, such as wyoming-piper."""
    PIPER = "piper"
    """In this process: an extra, as it is GPL-3.0."""


class Settings(ServiceSettings):
    """Frozen; every number carries its unit in its name."""

    model_config = SettingsConfigDict(env_prefix="SPEECH_", frozen=True, protected_namespaces=())

    port: Port = 8005
    recognizer: RecognizerEngine = Field(default=RecognizerEngine.WHISPER, description="who reads what was said")
    openai_url: str = Field(default="", max_length=500, description="as far as /v1: http://nas.lan:8000/v1")
    openai_model: str = Field(default="whisper-1", min_length=1, max_length=100, description="as that server names it")
    openai_api_key: SecretStr = Field(default=SecretStr(""), description="where that server wants one")
    wyoming_recognizer: str = Field(default="", max_length=200, description="tcp://nas.lan:10300")
    wyoming_voice: str = Field(default="", max_length=200, description="tcp://nas.lan:10200")
    piper_voice: str = Field(default="", max_length=500, description="the .onnx file of a voice")
    server_timeout_s: float = Field(default=10.0, ge=0.5, le=60.0, description="for one answer of a server named above")
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
    nice: int = Field(
        default=5,
        ge=0,
        le=19,
        description="its process gives way so, as by nice(1): reading takes all cores, and a stop by curl is a process",
    )
    waiting_max: int = Field(
        default=4,
        ge=1,
        le=64,
        description="calls to read, and as many to speak, that may wait or run; one more gets 503",
    )
    listeners_max: int = Field(default=4, ge=1, le=64, description="open sockets; one more is closed with 1013")
    partial_period_s: float = Field(default=0.5, ge=0.3, le=5.0, description="between two partial readings")
    log_text: bool = Field(default=False, description="what was heard and said stands in the log; else only how much")
