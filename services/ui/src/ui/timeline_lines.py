"""The timeline's lines: what is said of an event, by whom and with which numbers. Pure."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from contracts.mission import Mission, MissionEvent, MissionState, Outcome
from contracts.vision import Verdict, Vote
from ui.i18n import N_, _
from ui.page_model import OUTCOMES, PHASES, Chip, Tone, duration

VERDICTS: Final = {
    Verdict.YES: (N_("yes"), Tone.GOOD),
    Verdict.NO: (N_("no"), Tone.BAD),
    Verdict.ABSTAIN: (N_("–"), Tone.QUIET),
}
VOTERS: Final = {"detector": N_("Detector"), "clip": N_("CLIP"), "vlm": N_("VLM")}
KIND_TONES: Final = {"found": Tone.GOOD, "votes": Tone.BUSY, "failure": Tone.WARN, "end": Tone.WARN}


class Show(StrEnum):
    """The timeline's filter."""

    ALL = N_("All")
    SEEING = N_("Vision")
    DRIVING = N_("Driving")
    TROUBLE = N_("Problems")


ABOUT_KIND: Final = {
    "votes": Show.SEEING,
    "sighting": Show.SEEING,
    "depth": Show.SEEING,
    "found": Show.SEEING,
    "navigation": Show.DRIVING,
    "motion": Show.DRIVING,
    "dock": Show.DRIVING,
    "undock": Show.DRIVING,
    "failure": Show.TROUBLE,
    "end": Show.TROUBLE,
}
ABOUT_STATE: Final = {
    MissionState.MEMORY_NAV: Show.DRIVING,
    MissionState.MOVING_TO_SCAN: Show.DRIVING,
    MissionState.APPROACHING: Show.DRIVING,
    MissionState.DRIVING_1M: Show.DRIVING,
    MissionState.MOVING: Show.DRIVING,
    MissionState.EXPLORING: Show.DRIVING,
    MissionState.SCANNING: Show.SEEING,
    MissionState.CENTERING: Show.SEEING,
    MissionState.DEPTH_CHECK: Show.SEEING,
    MissionState.EMERGENCY_STOP: Show.TROUBLE,
}
"""What a line is about whose kind does not say: the state it was told in."""


@dataclass(frozen=True, slots=True)
class Line:
    """One line of the timeline as it is shown."""

    time: str
    phase: str
    text: str
    tone: Tone
    votes: tuple[Chip, ...] = ()
    crop: int | None = None


def line(event: MissionEvent, started_s: float) -> Line:
    tone = KIND_TONES.get(event.kind, Tone.QUIET)
    if event.data.outcome is Outcome.FOUND:
        tone = Tone.GOOD
    if event.state is MissionState.EMERGENCY_STOP:
        tone = Tone.BAD
    return Line(
        time=duration(max(0.0, event.stamp_s - started_s)),
        phase=_(PHASES[event.state][0]),
        text=event.text,
        tone=tone,
        votes=vote_chips(event.data.votes),
        crop=event.data.picture,
    )


def shown(event: MissionEvent, show: Show) -> bool:
    if show is Show.ALL or (show is Show.SEEING and event.data.votes != ()):
        return True
    if event.state is MissionState.EMERGENCY_STOP:
        return show is Show.TROUBLE
    return ABOUT_KIND.get(event.kind, ABOUT_STATE.get(event.state)) is show


def vote_chip(vote: Vote) -> Chip:
    word, tone = VERDICTS[vote.verdict]
    score = "" if vote.score is None else f" {vote.score:.2f}"
    threshold = "" if vote.score is None or vote.threshold is None else f" / {vote.threshold:.2f}"
    return Chip(_(VOTERS.get(vote.voter, vote.voter)), f"{_(word)}{score}{threshold}", tone, vote.reason)


def vote_chips(votes: Sequence[Vote]) -> tuple[Chip, ...]:
    return tuple(vote_chip(vote) for vote in votes)


def ending_chips(mission: Mission) -> tuple[Chip, ...]:
    """A mission of the history, in a few facts."""
    if mission.outcome is None:
        word, tone = (_("Queued"), Tone.QUIET) if mission.queue_position is not None else (_("Running"), Tone.BUSY)
    else:
        word, tone = OUTCOMES[mission.outcome]
    facts = [Chip("", _(word), tone)]
    if mission.ended_s is not None:
        facts.append(Chip(_("Time"), duration(max(0.0, mission.ended_s - mission.started_s))))
    if mission.metres_driven_m > 0.0:
        facts.append(Chip(_("Driven"), f"{mission.metres_driven_m:.1f} m"))
    if mission.measured_distance_m is not None:
        facts.append(Chip(_("Distance"), f"{mission.measured_distance_m:.2f} m"))
    return tuple(facts)
