"""Writes every setting of every service into docs/settings.md: `.venv/bin/python tools/settings_page.py`."""

import re
from collections.abc import Iterator
from enum import Enum
from importlib import import_module
from pathlib import Path
from typing import Final, Literal, cast, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_settings import BaseSettings

PAGE: Final = Path(__file__).parents[1] / "docs/settings.md"
SERVICES: Final = ("coordinator", "inference", "memory", "robot_bridge", "speech", "ui")
CLIENTS: Final = ("ear", "home_assistant")
"""They ask and are asked by nobody: no port, no Redis."""
UNITS: Final = {
    "rad_s_px": "rad/s a pixel", "m_rad": "m/rad", "m_s2": "m/s²", "rad_s2": "rad/s²", "m_s": "m/s", "rad_s": "rad/s",
    "rad": "rad", "hz": "Hz", "px": "px", "m": "m", "s": "s", "days": "days", "percent": "%", "bytes": "bytes",
}  # fmt: skip
HEAD: Final = """# Settings

Written by `.venv/bin/python tools/settings_page.py` from the settings classes; a test compares. Each is an
environment variable. Lists and tables are written in JSON; one part of a topic is set as
`ROBOT_BRIDGE_ROS__SCAN__NAME=lidar/scan`, and keeps the others.
A service refuses to start with a value beyond its bounds, and with a variable of its prefix that is no setting: it says
where the setting has moved to, or which is nearest. A prefix as plain as `MEMORY_` may meet variables of others: a
container platform sets `..._SERVICE_HOST`, `..._SERVICE_PORT` and `..._PORT=tcp://...` for a service of that name, a
host perhaps a `..._LIMIT`. They stop the service too (systemd's two about memory pressure do not): unset them where it
starts.
"""


def settings_of(service: str) -> type[BaseSettings]:
    return cast(type[BaseSettings], import_module(f"{service}.settings").Settings)


def variables(settings: type[BaseSettings]) -> Iterator[tuple[str, FieldInfo, object]]:
    """Name in the environment, field and default of each setting; of nested parts each of theirs."""
    prefix, between = settings.model_config.get("env_prefix", ""), settings.model_config.get("env_nested_delimiter")
    return _variables(settings, prefix.upper(), between or "__", {})


def _variables(
    model: type[BaseModel], prefix: str, between: str, given: dict[str, object]
) -> Iterator[tuple[str, FieldInfo, object]]:
    """`given` are the values of the instance that is the part's default."""
    for name, field in model.model_fields.items():
        default = given.get(name, field.get_default(call_default_factory=True))
        part = field.annotation
        if isinstance(part, type) and issubclass(part, BaseModel) and not field.description:
            values = dict(default) if isinstance(default, BaseModel) else {}
            yield from _variables(part, f"{prefix}{name.upper()}{between}", between, values)
        else:
            yield f"{prefix}{name.upper()}", field, default


def page() -> str:
    return HEAD + "".join(_section(service) for service in (*SERVICES, *CLIENTS))


def _section(service: str) -> str:
    rows = "".join(_row(*one) for one in variables(settings_of(service)))
    return f"\n## {service}\n\n| setting | type | default | bounds | unit | |\n|---|---|---|---|---|---|\n{rows}"


def _row(name: str, field: FieldInfo, default: object) -> str:
    description = (field.description or "").replace("|", "\\|")
    cells = (f"`{name}`", _type(field), _default(default), _bounds(field), _unit(name), description)
    return f"| {' | '.join(cells)} |\n"


def _type(field: FieldInfo) -> str:
    kind = field.annotation
    if isinstance(kind, type) and issubclass(kind, Enum):
        return " or ".join(f"`{one.value}`" for one in kind)
    if get_origin(kind) is Literal:
        return " or ".join(f"`{one}`" for one in get_args(kind))
    text = kind.__name__ if isinstance(kind, type) and not get_args(kind) else str(kind)
    return re.sub(r"\b\w[\w.]*\.(?=\w)", "", text).replace(" | None", ", optional").replace("|", "\\|")


def _default(value: object) -> str:
    if isinstance(value, Enum):
        value = value.value
    elif isinstance(value, tuple):
        value = ", ".join(str(one.value if isinstance(one, Enum) else one) for one in cast(tuple[object, ...], value))
    elif isinstance(value, BaseModel):
        value = value.model_dump_json()
    return f"`{value}`" if value not in (None, "") else ""


def _bounds(field: FieldInfo) -> str:
    words = {"gt": "over {}", "ge": "from {}", "lt": "under {}", "le": "to {}"}
    found = [text.format(f"{value:g}") for one in field.metadata for key, text in words.items()
             if (value := getattr(one, key, None)) is not None]  # fmt: skip
    return ", ".join(found)


def _unit(name: str) -> str:
    word = name.lower().removesuffix("_max").removesuffix("_min").removesuffix("_memory")
    return next((unit for ending, unit in UNITS.items() if word.endswith(f"_{ending}")), "")


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
