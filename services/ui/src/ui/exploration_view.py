"""An exploration as the page shows it: who leads and why, what the model may still be asked, what was discovered."""

from dataclasses import dataclass
from typing import Final

from contracts.exploration import Discovery, ExplorationMode, ExplorationStatus
from contracts.mission import MissionStatus
from ui.i18n import N_, _
from ui.page_model import Chip, Tone

MODES: Final[dict[ExplorationMode, tuple[str, Tone]]] = {
    ExplorationMode.IDLE: (N_("over"), Tone.QUIET),
    ExplorationMode.MODEL: (N_("the model leads"), Tone.BUSY),
    ExplorationMode.FRONTIERS: (N_("to the borders of the map"), Tone.BUSY),
    ExplorationMode.REACTIVE: (N_("by the laser alone"), Tone.WARN),
    ExplorationMode.LISTENING: (N_("listening"), Tone.WARN),
    ExplorationMode.RETURNING: (N_("driving home"), Tone.BUSY),
}
NEARLY_SPENT: Final = 0.9
"""From this share on it is told in another colour."""


@dataclass(frozen=True, slots=True)
class ExplorationView:
    """`chips` empty: nothing was explored since the coordinator began."""

    chips: tuple[Chip, ...] = ()
    why: str = ""
    discoveries: tuple[str, ...] = ()
    """Newest first."""


def exploration_view(status: MissionStatus | None) -> ExplorationView:
    one = status.exploration if status is not None else None
    if one is None:
        return ExplorationView()
    word, tone = MODES[one.mode]
    chips = [Chip(_("Mode"), _(word), tone)]
    if one.model:
        chips += _of_the_model(one)
    chips += [Chip(_("Goals reached"), str(one.goals)), Chip(_("Borders left"), str(one.frontiers))]
    if one.explored_m2 is not None:
        chips.append(Chip(_("Floor"), f"{one.explored_m2:.0f} m²"))
    found = tuple(_discovery(each) for each in reversed(one.discoveries))
    return ExplorationView(tuple(chips), one.why, found)


def _of_the_model(one: ExplorationStatus) -> list[Chip]:
    chips = [
        _spent(_("Calls"), one.calls, one.calls_max, one.model),
        _spent(_("Tokens"), one.tokens, one.tokens_max, one.model),
        _spent(_("Waited, s"), round(one.waited_s), round(one.waited_s_max), one.model),
    ]
    if one.refused:
        chips.append(Chip(_("Refused"), str(one.refused), Tone.WARN, _("decisions that the check refused")))
    return chips


def _spent(label: str, used: int, most: int, model: str) -> Chip:
    return Chip(label, f"{used} / {most}", Tone.WARN if used >= NEARLY_SPENT * most else Tone.QUIET, model)


def _discovery(one: Discovery) -> str:
    note = f": {one.note}" if one.note else ""
    return f"{one.label}{note} (x {one.x_m:.1f} m, y {one.y_m:.1f} m)"
