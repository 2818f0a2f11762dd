"""docs/licences.md names every distribution that somebody gets; each has a reason and an accepted licence."""

from dataclasses import replace

import licences
import pytest


def test_the_page_is_as_the_distributions_are() -> None:
    assert licences.PAGE.read_text(encoding="utf-8") == licences.page(), "run tools/licences.py"


def test_every_licence_is_accepted() -> None:
    assert [(one.name, one.licence) for one in licences.entries() if not one.accepted] == []


def test_what_we_ask_for_ourselves_has_a_reason() -> None:
    assert [one.name for one in licences.entries() if one.asked_for and not one.why] == []


@pytest.mark.parametrize("licence", ["GPL-3.0-only", "MIT AND GPL-2.0-only", "not said", "AGPL-3.0-or-later"])
def test_another_licence_is_refused(licence: str) -> None:
    numpy = next(one for one in licences.entries() if one.name == "numpy")
    assert not replace(numpy, licence=licence).accepted
