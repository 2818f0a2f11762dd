"""docs/glossary.md has a line for every head noun of a public class name, and no name means two things unsaid."""

import ast
import re
from collections import defaultdict
from pathlib import Path

import pytest

from support.source import ROOT, SERVICES, SOURCES, modules

PAGE = (ROOT / "docs/glossary.md").read_text(encoding="utf-8")
LINES, _, REST = PAGE.partition("## Plain words")
PLAIN_PART, _, SAME_PART = REST.partition("## The same name in two places")
WORDS = re.findall(r"^- \*\*(\w+)\*\*: .+", LINES, re.MULTILINE)
PLAIN = set(re.findall(r"\w+", PLAIN_PART))
SAME = set(re.findall(r"`(\w+)`", SAME_PART))
PACKAGES = sorted({"contracts", "geometry", "vocabulary", "mesh", "atom_cli", *SERVICES} | (SOURCES.keys() & {"store"}))
PARTS = re.compile(r"[A-Z]+(?![a-z])|[A-Z][a-z0-9]+")


def public_classes() -> dict[str, set[Path]]:
    found: dict[str, set[Path]] = defaultdict(set)
    for package in PACKAGES:
        for module in modules(package):
            for node in ast.walk(module.tree):
                if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                    found[node.name].add(module.path)
    return found


def head_noun(name: str) -> str:
    """The last word: `MissionQueue` is a queue; a dimension (`Pose2D`) is no word."""
    return PARTS.findall(re.sub(r"\d+D?$", "", name))[-1].lower()


def explained(noun: str) -> bool:
    """In the singular too."""
    return not {noun, noun.removesuffix("s")}.isdisjoint({*WORDS, *PLAIN})


@pytest.mark.parametrize(("name", "noun"), [("MissionQueue", "queue"), ("Pose2D", "pose"), ("HTTPError", "error")])
def test_the_head_noun_is_the_last_word(name: str, noun: str) -> None:
    assert head_noun(name) == noun


def test_words_stand_in_alphabetical_order() -> None:
    assert sorted(WORDS) == WORDS


def test_every_head_noun_of_a_public_class_is_explained_or_plain() -> None:
    assert {noun for name in public_classes() if not explained(noun := head_noun(name))} == set()


def test_no_class_name_means_two_things_unless_the_page_says_that_it_is_one() -> None:
    assert {name for name, paths in public_classes().items() if len(paths) > 1} - SAME == set()
