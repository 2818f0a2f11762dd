"""The table of requirement A12, as data."""

import itertools
import re

import pytest

from contracts.mission import MissionState
from coordinator.core.rules import ApproachRule, CenteringRule, CoverageRule, ScanRule, ValidationRule
from coordinator.core.states.table import states
from coordinator.core.transitions import ALLOWED, SENTENCES, TRANSITIONS, diagram
from coordinator.write_states import page
from support.source import ROOT

S = MissionState

DRAWN = [
    (S.IDLE, S.MEMORY_NAV), (S.IDLE, S.SCANNING), (S.MEMORY_NAV, S.SCANNING), (S.MEMORY_NAV, S.MEMORY_NAV),
    (S.MEMORY_NAV, S.CENTERING), (S.SCANNING, S.CENTERING), (S.SCANNING, S.MOVING_TO_SCAN),
    (S.MOVING_TO_SCAN, S.SCANNING), (S.MOVING_TO_SCAN, S.MOVING_TO_SCAN), (S.MOVING_TO_SCAN, S.CENTERING),
    (S.MOVING_TO_SCAN, S.IDLE), (S.CENTERING, S.DEPTH_CHECK), (S.CENTERING, S.SCANNING), (S.DEPTH_CHECK, S.DONE),
    (S.DEPTH_CHECK, S.APPROACHING), (S.DEPTH_CHECK, S.DRIVING_1M), (S.DEPTH_CHECK, S.SCANNING),
    (S.DRIVING_1M, S.CENTERING), (S.APPROACHING, S.DONE), (S.APPROACHING, S.CENTERING), (S.DONE, S.IDLE),
    (S.EMERGENCY_STOP, S.IDLE),
]  # fmt: skip


def test_the_table_names_every_state() -> None:
    assert set(ALLOWED) == set(MissionState)


def test_by_every_rule_each_state_is_answered_for() -> None:
    rules = itertools.product(ApproachRule, CenteringRule, CoverageRule, ScanRule, ValidationRule)
    assert all(set(states(*chosen)) == set(MissionState) for chosen in rules)


def test_every_state_has_a_sentence() -> None:
    assert set(SENTENCES) == set(MissionState)
    assert all(sentence.endswith(".") for sentence in SENTENCES.values())


@pytest.mark.parametrize(("before", "after"), DRAWN)
def test_every_arrow_of_the_document_is_in_the_table(before: MissionState, after: MissionState) -> None:
    assert after in ALLOWED[before]


def test_every_state_but_the_stop_itself_can_be_stopped() -> None:
    assert all(S.EMERGENCY_STOP in ALLOWED[state] for state in MissionState if state is not S.EMERGENCY_STOP)


def test_a_stop_leads_to_idle_and_nowhere_else() -> None:
    assert ALLOWED[S.EMERGENCY_STOP] == {S.IDLE}


def test_resting_states_are_those_without_work() -> None:
    assert {state for state in MissionState if state.resting} == {S.IDLE, S.DONE, S.EMERGENCY_STOP}


def test_a_find_is_not_settled_until_it_was_celebrated() -> None:
    assert {state for state in MissionState if state.settled} == {S.IDLE, S.EMERGENCY_STOP}


def test_it_looks_often_while_it_searches_or_nears_and_seldom_while_it_drives_or_rests() -> None:
    seldom = {S.IDLE, S.MEMORY_NAV, S.MOVING_TO_SCAN, S.EXPLORING, S.DONE, S.EMERGENCY_STOP}
    assert {state for state in MissionState if not state.fast_detection} == seldom


def test_the_page_in_the_docs_is_the_table() -> None:
    assert (ROOT / "docs/mission-states.md").read_text(encoding="utf-8") == page()


def test_every_arrow_says_why_and_stands_in_the_diagram() -> None:
    drawn = set(re.findall(r"^    (\w+) --> (\w+):", diagram(), re.MULTILINE))
    arrows = {(a.value, b.value) for a, to in TRANSITIONS.items() for b in to if b is not S.EMERGENCY_STOP}
    assert drawn == arrows | {("every_state", "EMERGENCY_STOP")}
    assert all(why for to in TRANSITIONS.values() for why in to.values())
