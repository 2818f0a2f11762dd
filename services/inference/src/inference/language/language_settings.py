"""The settings of language and vision-language models; `settings.py` gives them their prefix."""

from enum import StrEnum
from ipaddress import ip_address
from typing import Annotated, Self
from urllib.parse import urlsplit

from pydantic import Field, SecretStr, field_validator, model_validator
from pydantic_settings import BaseSettings, NoDecode

LOCAL_SUFFIXES = (".local", ".lan", ".internal", ".home.arpa", ".localhost")


class ReaderKind(StrEnum):
    """Who may read a command."""

    OLLAMA = "ollama"
    OPENAI = "openai"
    RULES = "rules"


class ModelServer(StrEnum):
    """Which wire format a model is behind."""

    OLLAMA = "ollama"
    OPENAI = "openai"


class LanguageSettings(BaseSettings):
    language_order: Annotated[tuple[ReaderKind, ...], NoDecode] = Field(
        default=(ReaderKind.OLLAMA, ReaderKind.OPENAI, ReaderKind.RULES),
        description="who is asked first, e.g. 'rules,ollama'; those without a URL are passed over",
    )
    ollama_url: str = Field(default="", description="e.g. http://127.0.0.1:11434; empty = not used")
    ollama_model: str = Field(default="llama3.2:3b", description="the model that Ollama reads commands with")
    openai_url: str = Field(
        default="", description="any server of OpenAI's chat format, e.g. http://127.0.0.1:8080/v1; empty = not used"
    )
    openai_model: str = Field(default="default", description="the name it is served under; llama.cpp takes any")
    openai_api_key: SecretStr = Field(default=SecretStr(""), description="where the server wants one (vLLM)")
    remote_models_allowed: bool = Field(
        default=False, description="let commands and pictures leave the local network for the servers named above"
    )
    vlm_model: str = Field(default="", description="e.g. llava:7b; empty = no vision-language vote")
    vlm_server: ModelServer = Field(default=ModelServer.OLLAMA, description="the server of the vision-language model")
    parse_deadline_s: float = Field(default=8.0, gt=0.0, le=120.0, description="all models together, a command")
    reason_deadline_s: float = Field(default=15.0, gt=0.0, le=120.0, description="to phrase one answer")
    vlm_deadline_s: float = Field(
        default=15.0, gt=0.0, le=120.0, description="for the vision-language vote; past it the vote abstains"
    )
    model_retry_after_s: float = Field(default=30.0, ge=0.0, description="a language model that is down is left alone")

    @field_validator("language_order", mode="before")
    @classmethod
    def _listed(cls, value: object) -> object:
        return tuple(one.strip() for one in value.split(",") if one.strip()) if isinstance(value, str) else value

    @field_validator("language_order")
    @classmethod
    def _each_once_rules_at_least_last(cls, value: tuple[ReaderKind, ...]) -> tuple[ReaderKind, ...]:
        return tuple(dict.fromkeys((*value, ReaderKind.RULES)))

    @model_validator(mode="after")
    def _nothing_leaves_the_local_network(self) -> Self:
        for url in (self.ollama_url, self.openai_url):
            if url and not self.remote_models_allowed and not is_local(url):
                raise ValueError(f"{url} is not on the local network; INFERENCE_REMOTE_MODELS_ALLOWED=true permits it")
        return self


def is_local(url: str) -> bool:
    """Loopback and private addresses, names without a dot, and the suffixes of home networks."""
    host = (urlsplit(url if "//" in url else f"//{url}").hostname or "").rstrip(".")
    try:
        address = ip_address(host)
    except ValueError:
        return "." not in host or host.endswith(LOCAL_SUFFIXES)
    return address.is_private or address.is_loopback or address.is_link_local
