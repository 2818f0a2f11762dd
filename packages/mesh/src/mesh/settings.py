"""What the settings of every service begin with: where it listens, where Redis is, and what is refused."""

import os
from collections.abc import Iterable, Iterator
from difflib import get_close_matches
from ipaddress import ip_address
from pathlib import Path
from types import UnionType
from typing import Annotated, Final, Self, Union, get_args, get_origin

from pydantic import BaseModel, Field, SecretStr, ValidationError, model_validator
from pydantic_settings import BaseSettings, SettingsConfigDict, SettingsError

from mesh.access.credentials import CredentialStore

Port = Annotated[int, Field(ge=1, le=65535, description="TCP port to listen on")]

SYSTEMD: Final = {"MEMORY_PRESSURE_WATCH", "MEMORY_PRESSURE_WRITE"}
"""systemd tells these to every service; they are not memory's."""


class ClientSettings(BaseSettings):
    """Of a program that asks the services, and listens to no port itself. Read from the environment, with its own
    prefix; frozen. A variable that is no setting is refused.
    """

    model_config = SettingsConfigDict(frozen=True)

    key: SecretStr | None = Field(default=None, description="this service's own key, for the others; or in a file")
    key_file: Path | None = Field(default=None, description="holds this service's own key")

    @property
    def own_key(self) -> SecretStr | None:
        """What the service says who it is with. Raises `SystemExit` when its file cannot be read."""
        if self.key is not None or self.key_file is None:
            return self.key
        try:
            return SecretStr(self.key_file.read_text(encoding="utf-8").strip())
        except OSError as error:
            raise SystemExit(f"{_names(type(self))[0]}KEY_FILE: {self.key_file}: {error.strerror}") from None

    @classmethod
    def read(cls) -> Self:
        """From the environment; raises `SystemExit` with a sentence for each variable that is refused."""
        try:
            return cls()
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


class ServiceSettings(ClientSettings):
    """Of a service, which others ask."""

    model_config = SettingsConfigDict(frozen=True)

    host: str = Field(default="127.0.0.1", description="addresses to listen on, commas between; 0.0.0.0 for every one")
    port: Port
    redis_url: str = Field(
        default="redis://127.0.0.1:6379/0",
        description="of the bus; redis://NAME@host takes a password made of the service's own key",
    )
    origins_allowed: tuple[str, ...] = Field(
        default=(), description='further names it goes by, e.g. behind a proxy: ["https://robot.example"]'
    )
    keys_file: Path | None = Field(
        default=None, description="who may what, as `atom keys make` writes it; none = anybody, from this machine only"
    )

    @model_validator(mode="after")
    def _stays_on_this_machine_without_keys(self) -> Self:
        if self.keys_file is None and not all(map(_is_here, self.host.split(","))):
            prefix = _names(type(self))[0]
            raise ValueError(
                f"{prefix}HOST={self.host} without keys: whoever reached the port could do anything. "
                f"`atom keys make` makes them, {prefix}KEYS_FILE names their file; or leave {prefix}HOST at 127.0.0.1"
            )
        return self

    def credential_store(self) -> CredentialStore | None:
        """Raises `SystemExit` when the file of keys cannot be read."""
        try:
            return CredentialStore(self.keys_file) if self.keys_file is not None else None
        except ValueError as error:
            raise SystemExit(f"{_names(type(self))[0]}KEYS_FILE: {error}") from None


def _is_here(host: str) -> bool:
    try:
        return ip_address(host.strip()).is_loopback
    except ValueError:
        return host.strip() == "localhost"


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
