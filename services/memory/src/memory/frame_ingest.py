"""From what perception publishes to frames worth remembering: where each thing is, and what is missing (shell)."""

import asyncio
from collections.abc import Sequence

from contracts.geometry import Pose2D
from contracts.measuring import LocalizeRequest, Measurement
from contracts.memory import Area, Look, Observation, SeenBox
from contracts.problem import Dependency, DependencyState
from contracts.vision import Detections
from geometry.grids import OccupancyGrid
from memory.frames import Camera, Exclusion, Frame, Tally, observations
from memory.negative_evidence import Expected, classify, clear, expected, range_towards, seen_in
from memory.ports import DepthAndMap, Store
from memory.settings import Settings
from mesh.errors import UnavailableError

NOT_DESCRIBED = "it has not described its robot yet"
AROUND_M = 5.0
"""Things farther from the robot than this are in no look."""
THINGS_AROUND = 500
DEPTHS_MAX = 12
"""Of one frame; what is missing beyond that has to wait for the next."""


class FrameIngest:
    """The places of what was seen come with the frame. What should be there and was not seen is measured in one call,
    while the frame is still in robot_bridge's depth history. Where nothing is measured, the map alone says what is
    hidden; an answer that comes too late leaves a look without a verdict.
    """

    def __init__(self, settings: Settings, store: Store, senses: DepthAndMap | None) -> None:
        self._settings = settings
        self._store = store
        self._senses = senses
        self._excluded = Exclusion.of(settings.excluded_labels)
        self.camera: Camera | None = None
        """None before the robot is described: nobody knows what is in view then."""

    def dependency(self) -> Dependency:
        state = DependencyState.READY if self.camera is not None else DependencyState.WARNING
        return Dependency(name="robot.description", state=state, detail="" if self.camera else NOT_DESCRIBED)

    async def frame_of(self, message: Detections, map_number: int) -> Frame | None:
        """Every frame is a look, too; none where the robot did not know where it was."""
        if message.pose is None:
            return None
        seen = observations(message, message.pose, self._excluded, self._settings.confidence_min)
        look = Look(
            pose=message.pose,
            stamp_s=message.stamp_s,
            image_width_px=message.image_width_px,
            image_height_px=message.image_height_px,
            seen=tuple(SeenBox(label=one.label, bbox_xyxy=one.bbox_xyxy) for one in message.detections),
        )
        try:
            return (await self.judge(look, map_number, seen))[0]
        except UnavailableError:  # what should have been there is not known now; what was seen is
            return Frame(pose=message.pose, stamp_s=message.stamp_s, seen=seen, map_number=map_number)

    async def judge(self, look: Look, map_number: int, seen: tuple[Observation, ...] = ()) -> tuple[Frame, Tally]:
        """The look as a frame with its misses, and how many things it confirmed, missed or could not tell.

        Raises `UnavailableError` where the database is away, and before the robot is described.
        """
        if self.camera is None:
            raise UnavailableError("robot_bridge", NOT_DESCRIBED)
        around = await self._store.things(None, _around(look.pose), THINGS_AROUND, map_number)
        wanted = expected(look, around, self.camera, self._settings.look_range_m)
        depths, ground = await self._sight(look, wanted)
        confirmed, missing, undetermined = classify(look, wanted, lambda one: depths.get(one.thing.id), ground)
        frame = Frame(
            pose=look.pose,
            stamp_s=look.stamp_s,
            seen=seen,
            misses=tuple(one.miss() for one in missing),
            is_look=True,
            looked_for=frozenset(look.labels) if look.labels is not None else None,
            seen_labels=frozenset(box.label for box in look.seen),
            map_number=map_number,
        )
        return frame, Tally(len(confirmed), len(missing), len(undetermined))

    async def _sight(
        self, look: Look, wanted: Sequence[Expected]
    ) -> tuple[dict[int, Measurement], OccupancyGrid | None]:
        """How far one sees towards each thing that is not in the picture, by its id, and the map."""
        absent = [one for one in wanted if not seen_in(one, look)][:DEPTHS_MAX]
        if not absent:
            return {}, None
        if look.ranges_m is not None:
            return {one.thing.id: Measurement(depth_m=range_towards(one, look)) for one in absent}, None
        senses = self._senses
        if senses is None:
            return {}, None
        try:
            async with asyncio.timeout(self._settings.senses_timeout_s):
                ground = await senses.ground()
                asked = [one for one in absent if ground is None or clear(ground, look.pose, one.thing)]
                found = await senses.localize(_request(asked, look)) if asked else ()
        except TimeoutError:
            return {}, None
        return {one.thing.id: measured for one, measured in zip(asked, found or (), strict=False)}, ground


def _around(pose: Pose2D) -> Area:
    """No part of it lies outside the map that messages can name."""
    x, y = min(max(pose.x, -9_990.0), 9_990.0), min(max(pose.y, -9_990.0), 9_990.0)
    return Area(x_min=x - AROUND_M, y_min=y - AROUND_M, x_max=x + AROUND_M, y_max=y + AROUND_M)


def _request(asked: Sequence[Expected], look: Look) -> LocalizeRequest:
    return LocalizeRequest(
        boxes_xyxy=tuple(one.box for one in asked),
        image_width_px=look.image_width_px,
        image_height_px=look.image_height_px,
        stamp_s=look.stamp_s,
    )
