"""What the settings of every service begin with: where it listens, where Redis is, and what is refused."""

import os
from collections.abc import Iterable, Iterator
from difflib import get_close_matches
from types import UnionType
from typing import Annotated, Final, Self, Union, get_args, get_origin

from pydantic import BaseModel, Field, ValidationError, model_validator
from pydantic_settings import BaseSettings, SettingsConfigDict, SettingsError

Port = Annotated[int, Field(ge=1, le=65535, description="TCP port to listen on")]

SYSTEMD: Final = {"MEMORY_PRESSURE_WATCH", "MEMORY_PRESSURE_WRITE"}
"""systemd tells these to every service; they are not memory's."""


class ServiceSettings(BaseSettings):
    """Read from the environment, with the service's own prefix; frozen. A variable that is no setting is refused."""

    model_config = SettingsConfigDict(frozen=True)

    host: str = Field(default="127.0.0.1", description="addresses to listen on, commas between; 0.0.0.0 for every one")
    port: Port
    redis_url: str = Field(default="redis://127.0.0.1:6379/0", description="of the bus")

    @classmethod
    def read(cls) -> Self:
        """From the environment; raises `SystemExit` with a sentence for each variable that is refused."""
        try:
            return cls()  # pyright: ignore[reportCallIssue]  # each service has a port of its own by default
        except SettingsError as error:
            raise SystemExit(f"{error}: {error.__cause__}") from None
        except ValidationError as error:
            prefix, between = _names(cls)
            faults = [(between.join(str(part) for part in one["loc"]).upper(), one["msg"]) for one in error.errors()]
            told = (f"{prefix}{name}: {why}" if name else why.removeprefix("Value error, ") for name, why in faults)
            raise SystemExit("\n".join(told)) from None

    @model_validator(mode="before")
    @classmethod
    def _knows_every_variable(cls, values: object) -> object:
        """Before any value is judged: a nested model would refuse an unknown name too, but name no nearest one."""
        if said := refusals(cls, os.environ):
            raise ValueError("\n".join(said))
        return values


def refusals(settings: type[BaseSettings], environment: Iterable[str]) -> list[str]:
    """A sentence for each variable with the service's prefix that is no setting of its."""
    prefix, between = _names(settings)
    known = {name.removeprefix(prefix) for name in _variables(settings, prefix, between)}
    told = sorted({name.upper() for name in environment if name.upper().startswith(prefix)} - SYSTEMD)
    return [_refusal(prefix, own, between, known) for name in told if (own := name.removeprefix(prefix)) not in known]


def _refusal(prefix: str, own: str, between: str, known: set[str]) -> str:
    moved = [one for one in sorted(known) if between and one.endswith(f"{between}{own}")]
    if len(moved) == 1:
        return f"{prefix}{own} is no setting: it is {prefix}{moved[0]} now"
    near = get_close_matches(own, sorted(known), n=1)
    nearest = f": the nearest is {prefix}{near[0]}" if near else ""
    return f"{prefix}{own} is no setting{nearest}; unset it if it is another program's"


def _names(settings: type[BaseSettings]) -> tuple[str, str]:
    """What stands before every variable, and between a part and its own settings."""
    return settings.model_config.get("env_prefix", "").upper(), settings.model_config.get("env_nested_delimiter") or ""


def _variables(model: type[BaseModel], prefix: str, between: str) -> Iterator[str]:
    for name, field in model.model_fields.items():
        yield (variable := f"{prefix}{name.upper()}")
        kind = field.annotation
        for part in get_args(kind) if get_origin(kind) in (Union, UnionType) else (kind,):
            if between and isinstance(part, type) and issubclass(part, BaseModel):
                yield from _variables(part, f"{variable}{between}", between)
