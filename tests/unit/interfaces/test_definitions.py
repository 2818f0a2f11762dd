"""The definition files say what the robot's own packages say, field by field."""

import pytest
from interface_wheels.sources import PACKAGES_DIR, InterfacePackage, read_packages

from support.ros_interfaces import INTERFACES

DEFINITIONS = {
    path.relative_to(PACKAGES_DIR).with_suffix("").as_posix(): path
    for kind in ("msg", "srv", "action")
    for path in PACKAGES_DIR.glob(f"*/{kind}/*.{kind}")
}


def sections_of(text: str) -> tuple[tuple[str, ...], ...]:
    """The lines that carry meaning, parted at `---`."""
    sections = text.split("\n---\n")
    return tuple(tuple(line for line in part.splitlines() if line and not line.startswith("#")) for part in sections)


def test_no_interface_is_missing_and_none_is_there_that_nobody_asked_for() -> None:
    assert set(DEFINITIONS) == set(INTERFACES)


@pytest.mark.parametrize("name", INTERFACES)
def test_a_definition_has_the_fields_and_constants_of_the_original_in_wire_order(name: str) -> None:
    assert sections_of(DEFINITIONS[name].read_text()) == INTERFACES[name]


@pytest.mark.parametrize("package", read_packages(), ids=lambda package: package.name)
def test_cmake_builds_every_definition_of_a_package_and_finds_what_its_manifest_names(
    package: InterfacePackage,
) -> None:
    cmake = (package.directory / "CMakeLists.txt").read_text()
    listed = {line.strip() for line in cmake.splitlines() if line.strip().endswith((".msg", ".srv", ".action"))}
    assert listed == {
        f"{path.parent.name}/{path.name}" for path in DEFINITIONS.values() if package.directory in path.parents
    }
    assert f"DEPENDENCIES {' '.join(package.depends)}\n" in cmake
