"""The endings: found, not found, unsure, docked, canceled, aborted; each says what it rests on."""

from contracts.mission import Candidate as CandidateRecord
from contracts.mission import EndCause, EventKind, MapTrouble, MissionState, Outcome
from contracts.vision import Vote
from coordinator.core import actions as do
from coordinator.core.activities import Nothing
from coordinator.core.report import (
    candidate_record,
    last_seen_in_words,
    looked_in_words,
    maybes,
    others_in_words,
    report,
)  # fmt: skip
from coordinator.core.step_context import Draft


def found(draft: Draft, distance_m: float | None, note: str) -> None:
    what = what_in_words(draft)
    away = "at an unknown distance" if distance_m is None else f"{distance_m:.2f} m away"
    reason = f"found the {what}, {away}" + (f" ({note})" if note else "") + _doubt(draft)
    draft.set_candidate(distance_m=distance_m)
    candidate = draft.candidate
    record = candidate_record(draft.mission, candidate, reason, narrow=False, now_s=draft.now_s)
    close(
        draft,
        Outcome.FOUND,
        reason,
        None,
        found=record.model_copy(update={"confirmed": True, "colour_unseen": _colour_unseen(draft)}),
    )
    votes = votes_data(candidate.votes)
    draft.go(
        MissionState.DONE,
        reason,
        kind=EventKind.FOUND,
        outcome=Outcome.FOUND.value,
        distance_m=distance_m,
        map_xy=candidate.map_xy,
        votes=votes,
        note=note,
        picture=draft.candidate.picture,
    )
    draft.be(Nothing(until_s=draft.now_s + draft.rules.done_reset_s))
    draft.act(do.Celebrate())


def _colour_unseen(draft: Draft) -> bool:
    return draft.mission.colour is not None and not draft.candidate.colour_named


def _doubt(draft: Draft) -> str:
    """What a person should know of a find that was confirmed: in poor light the votes on a crop can be wrong."""
    unseen = _colour_unseen(draft)
    return f"; no look at it named its colour: {draft.mission.colour} by the votes alone" if unseen else ""


def end(draft: Draft, outcome: Outcome, reason: str, by: EndCause | None, *, cause: str = "") -> None:
    """Every ending but success: stops, and the robot is idle at once."""
    draft.stop_motion()
    share = draft.search.share
    close(draft, outcome, reason, by, cause)
    draft.set(candidate=None, approach=None)
    draft.go(
        MissionState.IDLE,
        f"{outcome.value}: {reason}",
        kind=EventKind.END,
        outcome=outcome.value,
        looked_share=None if share is None else round(share, 3),
        rejected=rejected_data(draft),
    )
    draft.be(Nothing())


def abort(draft: Draft, by: EndCause, cause: str) -> None:
    """It cannot go on; what was found out until then is told with the cause."""
    end(draft, Outcome.ABORTED, cause, by, cause=cause)


MAP_TROUBLE_IN_WORDS = {
    MapTrouble.NO_FREE_SPACE: "the map shows no free space",
    MapTrouble.NO_ROOM: "the map shows no place with room for the robot",
    MapTrouble.ANOTHER_MAP: "the map was changed for that of another place",
}


def abort_for_the_map(draft: Draft, trouble: MapTrouble) -> None:
    """A search that ends for want of places was no search of all places."""
    draft.set_search(map_trouble=trouble)
    abort(draft, EndCause.MAP, MAP_TROUBLE_IN_WORDS[trouble])


def close(
    draft: Draft,
    outcome: Outcome,
    reason: str,
    by: EndCause | None,
    cause: str = "",
    *,
    found: CandidateRecord | None = None,
) -> None:
    """Writes the ending into the mission."""
    written = report(draft.mission, outcome, reason, by, cause, found=found)
    draft.set(outcome=outcome, reason=reason, ended_s=draft.now_s, report=written)


def give_up(draft: Draft, by: EndCause, why: str) -> None:
    """The search is over without a find: unsure when something may have been it, otherwise not found."""
    known = [looked_in_words(draft.mission), last_seen_in_words(draft.mission.last_seen, draft.now_s)]
    maybe = maybes(draft.mission)
    if maybe:
        told = "; ".join(part for part in (why, f"it may have been {maybe[-1]}", *known) if part)
        end(draft, Outcome.UNSURE, told, by)
        return
    refused = len(draft.search.rejections)
    known += [f"refused {refused} others" if refused else "", others_in_words(draft.mission)]
    told = "; ".join(part for part in (f"no {what_in_words(draft)}: {why}", *known) if part)
    end(draft, Outcome.NOT_FOUND, told, by)


def what_in_words(draft: Draft) -> str:
    return draft.mission.target.description if draft.mission.target is not None else "target"


def votes_data(votes: tuple[Vote, ...]) -> list[dict[str, object]]:
    return [v.model_dump(mode="json", include={"voter", "verdict", "score", "threshold", "reason"}) for v in votes]


def rejected_data(draft: Draft) -> list[dict[str, object]]:
    return [
        {"map_xy": r.map_xy, "narrow": r.narrow, "text": r.text, "votes": votes_data(r.votes)}
        for r in draft.search.rejections
    ]
