"""What the page shows of an exploration."""

from contracts.exploration import Discovery, ExplorationMode, ExplorationStatus
from contracts.mission import MissionStatus
from ui.exploration_view import MODES, ExplorationView, exploration_view
from ui.page_model import Tone


def shown(**facts: object) -> ExplorationView:
    told = {"mission_id": "m1", "mode": "frontiers", "why": "begun"} | facts
    return exploration_view(MissionStatus(stamp_s=1.0, exploration=ExplorationStatus.model_validate(told)))


def values(view: ExplorationView) -> dict[str, str]:
    return {chip.label: chip.value for chip in view.chips}


def test_nothing_is_shown_where_nothing_was_explored() -> None:
    assert exploration_view(None) == exploration_view(MissionStatus(stamp_s=1.0)) == ExplorationView()


def test_every_mode_has_words() -> None:
    assert set(MODES) == set(ExplorationMode)


def test_without_a_model_nothing_is_said_of_one() -> None:
    view = shown(goals=2, frontiers=3, explored_m2=17.6)
    assert (view.why, values(view)) == (
        "begun", {"Mode": "to the borders of the map", "Goals reached": "2", "Borders left": "3", "Floor": "18 m²"}
    )  # fmt: skip


def test_what_the_model_used_stands_beside_what_it_may_use_and_warns_when_it_is_nearly_spent() -> None:
    facts = {
        "calls": 270,
        "calls_max": 300,
        "tokens": 900,
        "tokens_max": 300_000,
        "waited_s": 61.4,
        "waited_s_max": 1800,
    }
    view = shown(mode="model", model="small", refused=4, **facts)
    assert [values(view)[name] for name in ("Mode", "Calls", "Tokens", "Waited, s", "Refused")] == [
        "the model leads", "270 / 300", "900 / 300000", "61 / 1800", "4"
    ]  # fmt: skip
    tones = {chip.label: chip.tone for chip in view.chips}
    assert (tones["Calls"], tones["Tokens"]) == (Tone.WARN, Tone.QUIET)


def test_discoveries_are_told_newest_first_with_their_place() -> None:
    found = [
        Discovery(label="kitchen", note="a fridge", x_m=1.0, y_m=2.0, stamp_s=3.0),
        Discovery(label="stairs", x_m=4.0, y_m=0.0, stamp_s=5.0),
    ]
    assert shown(discoveries=found).discoveries == (
        "stairs (x 4.0 m, y 0.0 m)", "kitchen: a fridge (x 1.0 m, y 2.0 m)"
    )  # fmt: skip
