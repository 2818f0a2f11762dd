"""The packages as they are pinned install with the oldest Python that the README names."""

from importlib.metadata import distributions

from packaging.specifiers import SpecifierSet

OLDEST = "3.11.2"
"""Debian 12's own."""


def test_every_package_takes_the_python_of_debian_12() -> None:
    wanted = {f"{one.name} {one.version}": one.metadata["Requires-Python"] or "" for one in distributions()}
    assert len(wanted) > 100
    assert {name: spec for name, spec in wanted.items() if not SpecifierSet(spec).contains(OLDEST)} == {}
