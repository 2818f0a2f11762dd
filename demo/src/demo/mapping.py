"""The mapping tour: what the robot would remember from having been driven through the home once.

The simulated robot is *placed* at each pose of a tour, in a second copy of the home in this process, not driven. Every
frame is looked at by the real detector (POST /detect); depth and place of each box are measured by robot_bridge's own
function, and what is worth remembering is chosen by memory's, as with frames of the driving robot. It goes to memory by
POST /observations once the tour is over: a place is told where two pictures of the tour agree on it; what only one
measured is told as a view, a pose of the robot from which it was seen (requirement A4). `--no-tour` leaves it out: the
robot then starts with an empty memory.
"""

import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence

import cv2
import httpx
import numpy as np

from contracts.memory import Observation, ObservationBatch, ObservationsReply
from contracts.vision import Detections
from demo.stack import Ports
from memory.frames import Exclusion, observations
from memory.objects import MapObject, first_seen, matches, usable_position
from memory.settings import Settings as MemorySettings
from robot_bridge.sensing.object_localizer import DepthView, measurements
from robot_bridge.sensing.sensor_readings import DepthImage, Intrinsics
from robot_bridge.sensing.transforms import Matrix, matrix
from robot_bridge.settings import Settings as BridgeSettings
from sim.home import Home
from sim.world import CameraModel, World
from sim.world.tour import TourFrame, tour_frames

OPTICAL_XYZW = (-0.5, 0.5, -0.5, 0.5)
"""A level camera that looks along the robot's x axis."""
BATCH = 500


def tour(home: Home, *, seed: int, ports: Ports, on_frame: Callable[[int], None]) -> tuple[int, int]:
    """Returns how many frames were looked at and how many observations memory stored."""
    told: list[Observation] = []
    frames = 0
    world = World(home, seed=seed)
    eyes = TourEyes(world.rgb_camera, world.depth_camera)
    try:
        with httpx.Client(trust_env=False, timeout=10.0) as client:
            for frame in tour_frames(world):
                answer = client.post(
                    f"{ports.url('inference')}/detect",
                    content=jpeg_of(frame),
                    headers={"content-type": "image/jpeg"},
                ).raise_for_status()
                seen = Detections.model_validate_json(answer.content)
                told += eyes.observations(frame, seen, time.time())
                frames += 1
                on_frame(frames)
            stored = sum(_remember(client, ports, batch) for batch in batches(agreed(told)))
    finally:
        world.close()
    return frames, stored


def jpeg_of(frame: TourFrame) -> bytes:
    encoded, picture = cv2.imencode(".jpg", cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, 90])
    assert encoded
    return picture.tobytes()


class TourEyes:
    """What robot_bridge and memory would make of a frame of the tour: their own functions, on the tour's own depth."""

    def __init__(self, rgb: CameraModel, depth: CameraModel) -> None:
        self._colour, self._depth = _intrinsics("rgb", rgb), _intrinsics("depth", depth)
        self._mount = _mount(rgb)
        self._depth_in_colour: Matrix = np.linalg.inv(self._mount) @ _mount(depth)
        self._noise = BridgeSettings.model_construct().depth_noise
        remembering = MemorySettings.model_construct()
        self._excluded = Exclusion.of(remembering.excluded_labels)
        self._confidence_min = remembering.confidence_min

    def observations(self, frame: TourFrame, seen: Detections, now_s: float) -> tuple[Observation, ...]:
        """`seen`: as inference answers for the frame's picture. One picture gives each thing one place, with the
        standard deviation of its depth, as one frame of the driving robot does."""
        image = DepthImage(now_s, self._depth.frame_id, frame.depth_m)
        view = DepthView(image, self._colour, self._depth, self._depth_in_colour, self._noise)
        pose, size_px = frame.estimate.pose, (seen.image_width_px, seen.image_height_px)
        boxes = [one.bbox_xyxy for one in seen.detections]
        measured = measurements(boxes, size_px, self._colour, self._mount, view, pose)
        placed = tuple(
            one.model_copy(update={"measurement": measurement})
            for one, measurement in zip(seen.detections, measured, strict=True)
        )
        told = seen.model_copy(update={"stamp_s": now_s, "pose": pose, "detections": placed})
        return observations(told, pose, self._excluded, self._confidence_min)


def agreed(told: Sequence[Observation]) -> list[Observation]:
    """Of a whole tour: places that no other picture measured too are left out; what was seen there stays.

    Two measurements agree where memory would take them for one thing. A box on nothing is seldom drawn twice, and at
    2.5 m one depth alone errs by a foot. In homes 7000 and 7001 that leaves 4 of 34 places on nothing, and 47 of 51
    things that can be asked for keep theirs (within 0.35 m).
    """
    by_label: dict[str, list[tuple[float, MapObject]]] = defaultdict(list)
    for one in told:
        if (position := usable_position(one)) is not None:
            by_label[one.label].append((one.stamp_s, first_seen(one, position, -1)))

    def confirmed(one: Observation) -> bool:
        others = [thing for stamp_s, thing in by_label[one.label] if stamp_s != one.stamp_s]
        return usable_position(one) is not None and matches([one], others) != [None]

    return [one if confirmed(one) else one.model_copy(update={"position": None, "sigma_m": None}) for one in told]


def batches(told: Sequence[Observation]) -> Iterator[ObservationBatch]:
    """In order, as many at once as memory takes."""
    for start in range(0, len(told), BATCH):
        yield ObservationBatch(observations=tuple(told[start : start + BATCH]))


def _mount(camera: CameraModel) -> Matrix:
    return matrix((camera.x_m, 0.0, camera.z_m), OPTICAL_XYZW)


def _intrinsics(frame_id: str, camera: CameraModel) -> Intrinsics:
    return Intrinsics(
        frame_id, camera.width_px, camera.height_px, camera.fx, camera.fy, camera.cx, camera.cy
    )  # fmt: skip


def _remember(client: httpx.Client, ports: Ports, batch: ObservationBatch) -> int:
    answer = client.post(
        f"{ports.url('memory')}/observations",
        content=batch.model_dump_json(),
        headers={"content-type": "application/json"},
    ).raise_for_status()
    return ObservationsReply.model_validate_json(answer.content).stored
