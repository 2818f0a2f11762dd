"""The endings: found, not found, unsure, canceled, aborted; each says what it rests on."""

from contracts.mission import MissionState, Outcome
from contracts.vision import Vote
from coordinator.core import actions as do
from coordinator.core.activities import Nothing
from coordinator.core.draft import Draft


def found(draft: Draft, distance_m: float | None, note: str) -> None:
    candidate = draft.candidate
    what = draft.mission.target.description if draft.mission.target is not None else "target"
    away = "at an unknown distance" if distance_m is None else f"{distance_m:.2f} m away"
    reason = f"found the {what}, {away}" + (f" ({note})" if note else "")
    draft.set_candidate(distance_m=distance_m)
    draft.set(outcome=Outcome.FOUND, reason=reason, ended_s=draft.now_s)
    votes = votes_data(candidate.votes)
    draft.go(
        MissionState.DONE,
        reason,
        kind="found",
        distance_m=distance_m,
        map_xy=candidate.map_xy,
        votes=votes,
        note=note,
    )
    draft.be(Nothing(until_s=draft.now_s + draft.rules.done_reset_s))
    draft.act(do.Celebrate())


def end(draft: Draft, outcome: Outcome, reason: str) -> None:
    """Every ending but success: stops, and the robot is idle at once."""
    draft.stop_motion()
    draft.set(outcome=outcome, reason=reason, ended_s=draft.now_s, candidate=None, approach=None)
    draft.go(
        MissionState.IDLE,
        f"{outcome.value}: {reason}",
        kind="end",
        outcome=outcome.value,
        looked_share=round(draft.search.share, 3),
        rejected=rejected_data(draft),
    )
    draft.be(Nothing())


def give_up(draft: Draft, why: str) -> None:
    """The search is over without a find: unsure when something was refused narrowly, otherwise not found."""
    search = draft.search
    what = draft.mission.target.description if draft.mission.target is not None else "target"
    looked = f"{search.share * 100:.0f} % of the free space looked at from {len(search.looked)} places"
    if search.unreachable:
        looked += f", {len(search.unreachable)} could not be reached"
    maybe = [r.text for r in search.rejections if r.narrow] + [loss.text for loss in search.losses if loss.confirmed]
    if maybe:
        end(draft, Outcome.UNSURE, f"{why}; it may have been {maybe[-1]}; {looked}")
        return
    seen = f"; refused {len(search.rejections)} others" if search.rejections else ""
    end(draft, Outcome.NOT_FOUND, f"no {what}: {why}; {looked}{seen}")


def votes_data(votes: tuple[Vote, ...]) -> list[dict[str, object]]:
    return [v.model_dump(mode="json", include={"voter", "verdict", "score", "threshold", "reason"}) for v in votes]


def rejected_data(draft: Draft) -> list[dict[str, object]]:
    return [
        {"map_xy": r.map_xy, "narrow": r.narrow, "text": r.text, "votes": votes_data(r.votes)}
        for r in draft.search.rejections
    ]
