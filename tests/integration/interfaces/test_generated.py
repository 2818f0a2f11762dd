"""The imported classes have the fields, types and constants that the robot's own have, in wire order."""

import importlib
import re
from typing import Any

import pytest

from support.ros_interfaces import INTERFACES

PARTS = {"msg": ("",), "srv": (".Request", ".Response"), "action": (".Goal", ".Result", ".Feedback")}
PYTHON_NAMES = {"bool": "boolean", "float32": "float", "float64": "double"}
SECTIONS = [
    (name, part, section)
    for name, sections in INTERFACES.items()
    for part, section in zip(PARTS[name.split("/")[1]], sections, strict=True)
]


def imported(name: str, part: str) -> Any:
    package, kind, message = name.split("/")
    found: Any = getattr(importlib.import_module(f"{package}.{kind}"), message)
    return getattr(found, part[1:]) if part else found


def python_type(ros_type: str) -> str:
    """How rosidl's Python generator names a type: `T[]` is `sequence<T>`, a bool a boolean."""
    unbounded = re.fullmatch(r"(.+)\[\]", ros_type)
    return f"sequence<{python_type(unbounded[1])}>" if unbounded else PYTHON_NAMES.get(ros_type, ros_type)


@pytest.mark.parametrize(("name", "part", "section"), SECTIONS, ids=lambda value: str(value) if value else "all")
def test_a_class_has_its_fields_in_order_and_its_constants(name: str, part: str, section: tuple[str, ...]) -> None:
    fields = [line.split(" ") for line in section if "=" not in line]
    constants = [re.split("[ =]", line) for line in section if "=" in line]
    kind = imported(name, part)
    expected = {field: python_type(ros_type) for ros_type, field in fields}
    assert list(kind.get_fields_and_field_types().items()) == list(expected.items())
    assert {constant: getattr(kind, constant) for _, constant, _ in constants} == {
        constant: int(value) for _, constant, value in constants
    }
