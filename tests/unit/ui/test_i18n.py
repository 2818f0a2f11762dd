"""The page's words in another language."""

import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from support.ui_world import mission, status
from ui import i18n
from ui.latest_facts import LatestFacts
from ui.page_model import page_model


@pytest.fixture(autouse=True)
def english_again() -> Iterator[None]:
    yield
    i18n.use({})


def test_a_translation_replaces_the_words_and_keeps_the_numbers(tmp_path: Path) -> None:
    file = tmp_path / "de.toml"
    file.write_text('"{n:.0f} s ago" = "vor {n:.0f} s"\n"Looking around" = "schaut sich um"\n', encoding="utf-8")
    i18n.use(i18n.load(file))
    assert i18n._("{n:.0f} s ago", n=7.2) == "vor 7 s"
    facts = LatestFacts()
    facts.take_mission(status(mission()), 1.0)
    assert page_model(facts, now_s=1.0, silence_s_max=2.0).phase == "schaut sich um"


def test_what_is_not_translated_stays_english() -> None:
    i18n.use({"Find": "Suche"})
    assert (i18n._("Find"), i18n._("Ask")) == ("Suche", "Ask")


def test_a_file_that_holds_no_texts_is_refused_by_name(tmp_path: Path) -> None:
    file = tmp_path / "odd.toml"
    file.write_text('"Find" = 7\n', encoding="utf-8")
    with pytest.raises(ValueError, match="Find"):
        i18n.load(file)


def test_the_template_names_every_text_of_page_and_scripts() -> None:
    template = tomllib.loads(i18n.template())
    assert {"STOP", "Find", "Looking around", "No picture yet", "Go there"} <= template.keys()
    assert set(i18n.for_scripts()) <= template.keys()
