"""What an ending rests on, put together from what the mission knows (the three honest endings)."""

from contracts.geometry import Pose2D
from contracts.mission import Candidate as CandidateRecord
from contracts.mission import EndCause, LastSeen, Outcome, Report, SeenInstead
from contracts.vision import Detections, Target
from coordinator.core.mission import Candidate, Loss, Mission, Rejection
from vocabulary.rooms import called

CANDIDATES_MAX = 20
OTHERS_MAX = 40
OTHERS_TOLD = 20
MINUTE_S, HOUR_S, DAY_S = 60.0, 3600.0, 86400.0


def candidate_record(
    mission: Mission, candidate: Candidate, text: str, *, narrow: bool, now_s: float
) -> CandidateRecord:
    """The candidate as it was judged."""
    xy, target = candidate.map_xy, mission.target
    place = None if xy is None else Pose2D(x=xy[0], y=xy[1], yaw=0.0)
    return CandidateRecord(
        text=text[:500],
        label=target.label if target is not None else "thing",
        colour=candidate.sighting.colour,
        place=place,
        seen_from=mission.robot.pose,
        distance_m=candidate.distance_m,
        confidence=candidate.sighting.confidence,
        votes=candidate.votes,
        log_odds=candidate.log_odds,
        confirmed=candidate.confirmed,
        narrow=narrow,
        picture=candidate.picture,
        stamp_s=max(0.0, candidate.judged_s if candidate.judged_s is not None else now_s),
    )


def report(
    mission: Mission,
    outcome: Outcome,
    text: str,
    by: EndCause | None,
    cause: str,
    *,
    found: CandidateRecord | None = None,
) -> Report:
    search = mission.search
    return Report(
        text=text[:1000],
        found=found,
        candidates=tuple(unconfirmed_candidates(mission)) if outcome is not Outcome.FOUND else (),
        looked_share=None if search.explored_fraction is None else min(1.0, max(0.0, search.explored_fraction)),
        rooms=mission.area.rooms if mission.area is not None else (),
        elsewhere=mission.elsewhere if outcome is not Outcome.FOUND else (),
        places_looked=len(search.visited),
        places_unreachable=len(search.unreachable),
        last_seen=mission.last_seen,
        seen_instead=search.other_objects[:OTHERS_TOLD],
        ended_by=by,
        cause=cause[:500],
        map_trouble=search.map_trouble,
    )


def unconfirmed_candidates(mission: Mission) -> list[CandidateRecord]:
    """What was not taken, the likeliest first: validated but lost, then refused narrowly, then the rest."""
    judged: list[Rejection | Loss] = [*mission.search.losses, *mission.search.rejections]
    records = [one.record for one in judged if one.record is not None]
    records.sort(key=lambda r: (r.confirmed, r.narrow, r.confidence or 0.0), reverse=True)
    return records[:CANDIDATES_MAX]


def possible_matches(mission: Mission) -> list[str]:
    """What may have been it after all, in words."""
    narrow = [r.text for r in mission.search.rejections if r.narrow]
    return narrow + [loss.text for loss in mission.search.losses if loss.confirmed]


def count_objects_in(
    others: tuple[SeenInstead, ...], target: Target | None, seen: Detections
) -> tuple[SeenInstead, ...]:
    """The tally with one more frame in it: everything but the target (its colour too, where one was asked for)."""
    tally = {(one.label, one.colour): one for one in others}
    for kind in {(d.label, d.colour) for d in seen.detections}:
        if kind[0] == "person" or (target is not None and target.may_be(*kind)):
            continue
        confidence = max(d.confidence for d in seen.detections if (d.label, d.colour) == kind)
        old = tally.get(kind)
        better = old is None or confidence > old.confidence
        tally[kind] = SeenInstead(
            label=kind[0],
            colour=kind[1],
            times=1 if old is None else old.times + 1,
            confidence=confidence if old is None else max(confidence, old.confidence),
            seen_from=seen.pose if better or old is None else old.seen_from,
        )
    kept = sorted(tally.values(), key=lambda one: (-one.times, one.label, one.colour or ""))
    return tuple(kept[:OTHERS_MAX])


def looked_in_words(mission: Mission) -> str:
    search = mission.search
    space = f"the free space of {mission.area_called}" if mission.area is not None else "the free space"
    looked = "" if search.explored_fraction is None else f"{search.explored_fraction * 100:.0f} % of {space} searched "
    looked += f"from {len(search.visited)} places" if looked else f"{len(search.visited)} places searched"
    if search.unreachable:
        looked += f", {len(search.unreachable)} could not be reached"
    return looked


def last_seen_in_words(last: LastSeen | None, now_s: float) -> str:
    if last is None:
        return ""
    return f"last seen {ago(now_s - last.stamp_s)} from x {last.pose.x:.1f} m, y {last.pose.y:.1f} m"


def elsewhere_in_words(mission: Mission, now_s: float) -> str:
    """What memory knew of it outside the rooms that were looked in."""
    told = [
        f"one was seen in {called(one.room)} {ago(now_s - one.stamp_s)}"
        if one.room
        else f"one was seen at x {one.place.x:.1f} m, y {one.place.y:.1f} m {ago(now_s - one.stamp_s)}"
        for one in mission.elsewhere[:3]
    ]
    return ", ".join(told)


def others_in_words(mission: Mission, lead: str = "seen instead") -> str:
    named = [f"{one.colour} {one.label}" if one.colour else one.label for one in mission.search.other_objects[:4]]
    return f"{lead}: {', '.join(named)}" if named else ""


def ago(seconds: float) -> str:
    if seconds < 2 * MINUTE_S:
        return "just now" if seconds < MINUTE_S else "a minute ago"
    if seconds < 2 * HOUR_S:
        return f"{seconds / MINUTE_S:.0f} minutes ago"
    return f"{seconds / HOUR_S:.0f} hours ago" if seconds < 2 * DAY_S else f"{seconds / DAY_S:.0f} days ago"
