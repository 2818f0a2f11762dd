"""`python -m sim` before it opens anything: what it takes and what it refuses."""

import subprocess
import sys

import pytest

from sim.__main__ import parse_wanted
from sim.home import Wanted


@pytest.mark.parametrize(
    ("phrase", "wanted"),
    [
        ("red bottle", Wanted("bottle", "red")),
        ("Teddy Bear", Wanted("teddy bear", None)),
        ("orange", Wanted("orange", None)),
        ("  ", None),
    ],
)
def test_what_a_home_must_hold_is_read_from_plain_words(phrase: str, wanted: Wanted | None) -> None:
    assert parse_wanted(phrase) == wanted


@pytest.mark.parametrize(
    "arguments",
    [("--want", "green unicorn"), ("--home", "/no/such/file.json"), ("--seed", "-1"), ("--colour", "red")],
)
def test_what_makes_no_sense_is_refused_with_a_sentence_and_exit_code_2(arguments: tuple[str, ...]) -> None:
    run = subprocess.run(
        [sys.executable, "-m", "sim", *arguments], capture_output=True, text=True, timeout=60, check=False
    )
    assert run.returncode == 2
    assert arguments[1].split()[-1] in run.stderr or arguments[0].strip("-") in run.stderr
    assert "Traceback" not in run.stderr
