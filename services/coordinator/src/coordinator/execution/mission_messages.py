"""The core's mission as the other services see it."""

from contracts import mission as wire
from contracts.geometry import Pose2D
from contracts.mission import MissionStatus, MissionTarget
from coordinator.core.activities import Waiting, WaitingForPlace, Waking
from coordinator.core.mission import Mission


def mission_record(mission: Mission, trace_id: str) -> wire.Mission | None:
    """None before the first mission."""
    if mission.id == "":
        return None
    candidate = mission.candidate
    votes = candidate.votes if candidate is not None else ()
    if not votes and mission.search.rejections:
        votes = mission.search.rejections[-1].votes
    xy = candidate.map_xy if candidate is not None else None
    return wire.Mission(
        id=mission.id,
        kind=mission.kind,
        command=mission.command,
        target=mission.target,
        parser=mission.parser,
        action=mission.action,
        rooms=mission.area.rooms if mission.area is not None else (),
        state=mission.state,
        paused=mission.paused,
        request_id=mission.order.request_id,
        part=mission.order.part,
        parts=mission.order.parts,
        asked_s=mission.order.asked_s,
        outcome=mission.outcome,
        reason=mission.reason or mission.progress,
        started_s=mission.started_s,
        ended_s=mission.ended_s,
        votes=votes,
        measured_distance_m=candidate.distance_m if candidate is not None else None,
        target_pose=Pose2D(x=xy[0], y=xy[1], yaw=0.0) if xy is not None else None,
        metres_driven_m=round(mission.metres_m, 3),
        report=mission.report,
        map_id=mission.map_id,
        trace_id=trace_id,
    )


def mission_status(
    mission: Mission, now_s: float, *, queue: tuple[wire.Mission, ...] = (), trace_id: str = ""
) -> MissionStatus:
    search = mission.search
    still = (*(place.pose for place in search.views), *search.points) if mission.running else ()
    return MissionStatus(
        stamp_s=max(0.0, now_s),
        state=mission.state,
        mission=mission_record(mission, trace_id),
        progress=mission.progress[:500],
        waiting_for=waiting_for(mission, now_s),
        queue=queue[:50],
        scan_points=still[:2000],
        scan_points_done=search.visited[-2000:],
    )


def waiting_for(mission: Mission, now_s: float) -> str:
    """What it waits for, as the service whose call failed, and for how much longer; empty while nothing is amiss."""
    waiting = mission.activity
    if isinstance(waiting, Waking):
        return "camera"
    if isinstance(waiting, WaitingForPlace):
        return f"{waiting.service}: for {max(0.0, waiting.until_s - now_s):.0f} s at most"
    if not isinstance(waiting, Waiting):
        return ""
    tries = f"{mission.failures} of {mission.rules.failures_max} tries"
    return f"{waiting.service}: again in {max(0.0, waiting.until_s - now_s):.0f} s ({tries})"


def mission_target(mission: Mission) -> MissionTarget:
    if not mission.running:
        return MissionTarget()
    return MissionTarget(target=mission.target, mission_id=mission.id, fast=mission.state.fast_detection)
