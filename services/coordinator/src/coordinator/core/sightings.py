"""Which boxes of a frame may be the target, which of them is the one followed, and which were judged already."""

import math
from collections.abc import Sequence
from dataclasses import replace

from contracts.colours import Colour
from contracts.geometry import Pose2D
from contracts.mission import SeenElsewhere
from contracts.robot import BoxQuery
from contracts.vision import Detection, Detections
from coordinator.core.area import BESIDE_M
from coordinator.core.geometry import pixel_bearing_rad, relative
from coordinator.core.mission import Candidate, Loss, Mission, Rejection, Sighting
from coordinator.core.plausibility import plausible
from coordinator.core.report import candidate_record, count_objects_in
from coordinator.core.step_context import StepContext
from coordinator.core.tracking import Track, fused, measured
from geometry.poses import apart_m, wrap

ELSEWHERE_MAX = 20
"""Of what is known of the target outside the rooms that a mission keeps to."""
FRAME_PX = 320
"""The width the requirements' pixel numbers belong to; other widths are scaled to it."""


def sightings(mission: Mission, seen: Detections) -> tuple[Sighting, ...]:
    """Every box of the target's class whose colour agrees or is unknown: agreeing first, then by confidence. Not what
    was measured to stand outside the rooms that the mission keeps to.
    """
    if mission.target is None:
        return ()
    target = mission.target
    boxes = [d for d in seen.detections if target.may_be(d.label, d.colour) and not _is_elsewhere(mission, d)]
    boxes.sort(key=lambda d: (target.colour in {None, d.colour}, d.confidence), reverse=True)
    yaw = seen.pose.yaw if seen.pose is not None else mission.robot.yaw
    return tuple(_sighting(mission, seen, d, yaw) for d in boxes)


def _is_elsewhere(mission: Mission, detection: Detection) -> bool:
    measurement = plausible(detection.measurement, mission.rules)
    at = measurement.map_point
    if mission.area is None or at is None:
        return False
    return not mission.area.holds(at.x, at.y, within_m=max(BESIDE_M, 2.0 * (measurement.sigma_m or 0.0)))


def _sighting(mission: Mission, seen: Detections, detection: Detection, yaw: float) -> Sighting:
    u_px = (detection.bbox_xyxy[0] + detection.bbox_xyxy[2]) / 2
    box = BoxQuery(
        bbox_xyxy=detection.bbox_xyxy,
        image_width_px=seen.image_width_px,
        image_height_px=seen.image_height_px,
        stamp_s=seen.stamp_s,
    )
    return Sighting(
        box=box,
        stamp_s=seen.stamp_s,
        confidence=detection.confidence,
        colour=detection.colour,
        bearing_rad=wrap(yaw + pixel_bearing_rad(u_px, seen.image_width_px, mission.rules.camera_hfov_rad)),
        error_px=(u_px - seen.image_width_px / 2) * FRAME_PX / seen.image_width_px,
        measurement=plausible(detection.measurement, mission.rules),
    )


def count_other_objects(context: StepContext, seen: Detections) -> None:
    """What else this frame shows, for the ending that has to say what was seen instead."""
    others = count_objects_in(context.search.other_objects, context.mission.target, seen)
    context.update_search(other_objects=others)
    keep_what_is_elsewhere(context, seen)


def keep_what_is_elsewhere(context: StepContext, seen: Detections, *, confidence_min: float = 0.0) -> None:
    """What may be the target and stands outside the rooms that the mission keeps to: the newest of each place."""
    mission = context.mission
    if mission.target is None or mission.area is None:
        return
    kept = mission.elsewhere
    for one in seen.detections:
        at = plausible(one.measurement, mission.rules).map_point
        if at is None or one.confidence < confidence_min:
            continue
        if not mission.target.may_be(one.label, one.colour) or not _is_elsewhere(mission, one):
            continue
        near_m = mission.rules.rejected_radius_m
        there = [old for old in kept if math.hypot(old.place.x - at.x, old.place.y - at.y) <= near_m]
        newest = SeenElsewhere(
            label=one.label,
            colour=one.colour,
            room=next((old.room for old in there if old.room), ""),
            place=Pose2D(x=at.x, y=at.y, yaw=0.0),
            stamp_s=seen.stamp_s,
        )
        kept = (newest, *(old for old in kept if old not in there))[:ELSEWHERE_MAX]
    if kept != mission.elsewhere:
        context.update(elsewhere=kept)


def bearing_error_rad(mission: Mission, sighting: Sighting) -> float:
    """How far to turn for the sighting to be in the middle, counter-clockwise positive."""
    return pixel_bearing_rad(FRAME_PX / 2 + sighting.error_px, FRAME_PX, mission.rules.camera_hfov_rad)


def tracked(mission: Mission, candidate: Candidate, seen: Detections) -> Sighting | None:
    """The box nearest to where the candidate is expected, none when none is near enough."""
    return _nearest(sightings(mission, seen), _expected_rad(mission, candidate), mission.rules.track_rad)


def colour_in_its_place(mission: Mission, candidate: Candidate, seen: Detections) -> Colour | None:
    """What colour this frame names for the thing of the class where the candidate is expected, none where it names
    none; whatever colour was asked for.
    """
    if mission.target is None:
        return None
    yaw = seen.pose.yaw if seen.pose is not None else mission.robot.yaw
    alike = [_sighting(mission, seen, d, yaw) for d in seen.detections if d.label == mission.target.label]
    there = _nearest(alike, _expected_rad(mission, candidate), mission.rules.rejected_bearing_rad)
    return there.colour if there is not None else None


def _expected_rad(mission: Mission, candidate: Candidate) -> float:
    """By its place where that is known, else where it was last seen."""
    pose, xy = mission.robot.pose, candidate.map_xy
    if xy is None or pose is None:
        return candidate.sighting.bearing_rad
    return math.atan2(xy[1] - pose.y, xy[0] - pose.x)


def _nearest(some: Sequence[Sighting], expected_rad: float, within_rad: float) -> Sighting | None:
    near = [s for s in some if abs(wrap(s.bearing_rad - expected_rad)) <= within_rad]
    return min(near, key=lambda s: abs(wrap(s.bearing_rad - expected_rad)), default=None)


def follow(context: StepContext, sighting: Sighting) -> None:
    named = context.candidate.colour_named or sighting.colour is not None
    track, seen = context.candidate.track, _located(sighting)
    if seen is not None:
        track = fused(track, seen) if track is not None else seen
    followed = replace(context.candidate, sighting=sighting, seen_s=context.now_s, colour_named=named, track=track)
    context.update(candidate=followed)


def new_candidate(context: StepContext, sighting: Sighting) -> None:
    named, here = sighting.colour is not None, context.mission.robot.pose
    context.update(
        candidate=Candidate(
            sighting=sighting, seen_s=context.now_s, colour_named=named, origin=here, track=_located(sighting)
        )
    )


def _located(sighting: Sighting) -> Track | None:
    """Its place alone, none where it was not measured."""
    found = sighting.measurement
    if found.map_point is None or found.distance_m is None:
        return None
    return measured(
        found.map_point.x,
        found.map_point.y,
        bearing_rad=sighting.bearing_rad,
        distance_m=found.distance_m,
        sigma_m=found.sigma_m or 0.0,
    )


def is_worth_pursuing(mission: Mission, sighting: Sighting) -> bool:
    """False for what was lost twice in this direction, and for unlocalised rejections in it."""
    lost = sum(_same_direction(mission, loss.origin, loss.bearing_rad, sighting) for loss in mission.search.losses)
    refused = any(
        r.map_xy is None and _same_direction(mission, r.origin, r.bearing_rad, sighting)
        for r in mission.search.rejections
    )
    return lost < 2 and not refused


def is_near_rejected(mission: Mission, sighting: Sighting) -> bool:
    """True when something rejected stands in that direction: it takes a measurement to tell the two apart."""
    pose = mission.robot.pose
    if pose is None:
        return False
    for rejection in mission.search.rejections:
        if rejection.map_xy is None:
            continue
        there = relative(*rejection.map_xy, pose)
        slack_rad = mission.rules.rejected_bearing_rad + math.atan2(0.25, max(there.distance_m, 0.25))
        if abs(wrap(pose.yaw + there.bearing_rad - sighting.bearing_rad)) <= slack_rad:
            return True
    return False


def is_refused(mission: Mission, map_xy: tuple[float, float] | None, distance_m: float | None) -> bool:
    """True for what stands where something was refused, unless it is seen from much nearer now than it was then."""
    if map_xy is None:
        return False
    near = [
        r
        for r in mission.search.rejections
        if r.map_xy is not None and math.dist(r.map_xy, map_xy) <= mission.rules.rejected_radius_m
    ]
    return any(not _much_nearer(mission, distance_m, r.distance_m) for r in near)


def _much_nearer(mission: Mission, now_m: float | None, then_m: float | None) -> bool:
    return now_m is not None and then_m is not None and now_m <= mission.rules.rejudge_share * then_m


def reject(context: StepContext, text: str, *, narrow: bool) -> None:
    """Remembers the candidate as not the target; the search goes on without it."""
    candidate, pose = context.candidate, context.mission.robot.pose
    record = candidate_record(context.mission, candidate, text, narrow=narrow, now_s=context.now_s)
    rejection = Rejection(
        map_xy=candidate.map_xy,
        origin=pose,
        bearing_rad=candidate.sighting.bearing_rad,
        narrow=narrow,
        text=text,
        votes=candidate.votes,
        record=record,
        distance_m=candidate.distance_m,
        sighting=candidate.sighting,
        revisited=candidate.revisited,
    )
    others = context.search.rejections
    if (
        candidate.other_sides > 0 and (at := candidate.map_xy) is not None
    ):  # its looks were weighed again: one word for it
        near_m = context.rules.rejected_radius_m
        others = tuple(r for r in others if r.map_xy is None or math.dist(r.map_xy, at) > near_m)
    context.update_search(rejections=(*others, rejection)[-100:])
    context.update(candidate=None, approach=None)


def lose(context: StepContext, why: str = "could not be seen again") -> None:
    """Remembers where the candidate was last seen from, and `why` it is left."""
    candidate = context.candidate
    where = "" if candidate.map_xy is None else f" at x {candidate.map_xy[0]:.1f} m, y {candidate.map_xy[1]:.1f} m"
    text = f"what was seen{where} and {why}"
    judged = candidate.confirmed or bool(candidate.votes)
    record = candidate_record(context.mission, candidate, text, narrow=candidate.confirmed, now_s=context.now_s)
    loss = Loss(
        context.mission.robot.pose,
        candidate.sighting.bearing_rad,
        candidate.confirmed,
        text,
        record if judged else None,
    )
    context.update_search(losses=(*context.search.losses, loss)[-100:])
    context.update(candidate=None, approach=None)


def _same_direction(mission: Mission, origin: Pose2D | None, bearing_rad: float, sighting: Sighting) -> bool:
    pose = mission.robot.pose
    if abs(wrap(bearing_rad - sighting.bearing_rad)) > mission.rules.rejected_bearing_rad:
        return False
    return origin is None or pose is None or apart_m(pose, origin) <= mission.rules.rejected_radius_m
