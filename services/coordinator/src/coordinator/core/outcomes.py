"""The endings: found, not found, unsure, docked, canceled, aborted; each says what it rests on."""

from contracts.mission import Candidate as CandidateRecord
from contracts.mission import EndCause, EventFacts, EventKind, MapTrouble, MissionKind, MissionState, Outcome
from coordinator.core import actions as do
from coordinator.core.activities import Idle
from coordinator.core.mission import Mission
from coordinator.core.report import (
    candidate_record,
    elsewhere_in_words,
    last_seen_in_words,
    looked_in_words,
    others_in_words,
    possible_matches,
    report,
)  # fmt: skip
from coordinator.core.step_context import StepContext


def retry_or_abort(context: StepContext, service: str, detail: str, *, stopped: bool = False) -> None:
    """Waits and takes the state up again; many failures in a row end the mission, with the cause."""
    failures = context.mission.failures + 1
    if failures >= context.rules.failures_max:
        abort(context, EndCause.SERVICE, f"{service} failed {failures} times in a row: {detail}")
    else:
        context.retry_later(service, detail, stopped=stopped)


def found(context: StepContext, distance_m: float | None, note: str) -> None:
    what = what_in_words(context)
    away = "at an unknown distance" if distance_m is None else f"{distance_m:.2f} m away"
    reason = f"found the {what}, {away}" + (f" ({note})" if note else "") + _doubt(context)
    context.update_candidate(distance_m=distance_m)
    candidate = context.candidate
    record = candidate_record(context.mission, candidate, reason, narrow=False, now_s=context.now_s)
    close(
        context,
        Outcome.FOUND,
        reason,
        None,
        found=record.model_copy(update={"confirmed": True, "colour_unseen": _colour_unseen(context)}),
    )
    context.transition_to(
        MissionState.DONE,
        reason,
        kind=EventKind.FOUND,
        facts=EventFacts(
            outcome=Outcome.FOUND, distance_m=distance_m, votes=candidate.votes, picture=candidate.picture
        ),
    )
    context.set_activity(Idle(until_s=context.now_s + context.rules.done_reset_s))
    context.request(do.Celebrate())


def _colour_unseen(context: StepContext) -> bool:
    return context.mission.colour is not None and not context.candidate.colour_named


def _doubt(context: StepContext) -> str:
    """What a person should know of a find that was confirmed: in poor light the votes on a crop can be wrong."""
    unseen = _colour_unseen(context)
    return f"; no picture confirmed its colour; only the votes say {context.mission.colour}" if unseen else ""


def end(context: StepContext, outcome: Outcome, reason: str, by: EndCause | None, *, cause: str = "") -> None:
    """Every ending but success: stops, and the robot is idle at once."""
    context.stop_motion()
    share = context.search.explored_fraction
    close(context, outcome, reason, by, cause)
    context.update(candidate=None, approach=None)
    context.transition_to(
        MissionState.IDLE,
        f"{outcome.value}: {reason}",
        kind=EventKind.END,
        facts=EventFacts(outcome=outcome, looked_share=None if share is None else round(share, 3)),
    )
    context.set_activity(Idle())


def abort(context: StepContext, by: EndCause, cause: str) -> None:
    """It cannot go on; what was found out until then is told with the cause."""
    end(context, Outcome.ABORTED, cause, by, cause=cause)


MAP_TROUBLE_IN_WORDS = {
    MapTrouble.NO_FREE_SPACE: "the map shows no free space",
    MapTrouble.NO_ROOM: "the map shows no place with room for the robot",
    MapTrouble.ANOTHER_MAP: "the map was replaced by that of another place",
}


def abort_for_the_map(context: StepContext, trouble: MapTrouble) -> None:
    """A search that ends for want of places was no search of all places."""
    context.update_search(map_trouble=trouble)
    abort(context, EndCause.MAP, MAP_TROUBLE_IN_WORDS[trouble])


def close(
    context: StepContext,
    outcome: Outcome,
    reason: str,
    by: EndCause | None,
    cause: str = "",
    *,
    found: CandidateRecord | None = None,
) -> None:
    """Writes the ending into the mission."""
    written = report(context.mission, outcome, reason, by, cause, found=found)
    context.update(outcome=outcome, reason=reason, ended_s=context.now_s, report=written)


def give_up(context: StepContext, by: EndCause, why: str) -> None:
    """The search is over without a find: unsure when something may have been it, otherwise not found. Where nothing
    was looked for, all of it is done.
    """
    if context.mission.kind is MissionKind.MOVE:
        seen = others_in_words(context.mission, "seen")
        end(context, Outcome.DONE, "; ".join(filter(None, (why, looked_in_words(context.mission), seen))), None)
        return
    by, why = _within(context.mission, by, why)
    known = [looked_in_words(context.mission), elsewhere_in_words(context.mission, context.now_s)]
    known.append(last_seen_in_words(context.mission.last_seen, context.now_s))
    maybe = possible_matches(context.mission)
    if maybe:
        told = "; ".join(part for part in (why, f"it may have been {maybe[-1]}", *known) if part)
        end(context, Outcome.UNSURE, told, by)
        return
    refused = len(context.search.rejections)
    known += [f"refused {refused} others" if refused else "", others_in_words(context.mission)]
    told = "; ".join(part for part in (f"no {what_in_words(context)}: {why}", *known) if part)
    end(context, Outcome.NOT_FOUND, told, by)


def _within(mission: Mission, by: EndCause, why: str) -> tuple[EndCause, str]:
    """The same of a search that kept to some rooms: where it saw nothing of them, no place of them was looked at."""
    if mission.area is None:
        return by, why
    if by is EndCause.ALL_LOOKED and not mission.search.explored_fraction:
        return EndCause.NO_PLACE_LEFT, f"no place in {mission.area_called} could be reached"
    return by, f"{why}; I looked in {mission.area_called} only"


def what_in_words(context: StepContext) -> str:
    return context.mission.target.description if context.mission.target is not None else "target"
