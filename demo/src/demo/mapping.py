"""The mapping tour: what the robot would remember from having been driven through the home once.

The simulated robot is *placed* at each pose of a tour, in a second copy of the home in this process, not driven; every
frame is looked at by the real detector (POST /detect), and what it sees goes to memory (POST /observations), as it does
while mapping by hand (requirement A4). `--no-tour` leaves it out: the robot then starts with an empty memory.
"""

import time
from collections.abc import Callable

import cv2
import httpx

from contracts.geometry import Pose2D
from contracts.memory import Observation, ObservationBatch, ObservationsReply
from contracts.vision import Detection, Detections
from demo.stack import Ports
from sim.home import Home
from sim.world import World
from sim.world.tour import tour_frames


def tour(home: Home, *, seed: int, ports: Ports, on_frame: Callable[[int], None]) -> tuple[int, int]:
    """Returns how many frames were looked at and how many observations memory stored."""
    frames = stored = 0
    world = World(home, seed=seed)
    try:
        with httpx.Client(trust_env=False, timeout=10.0) as client:
            for estimate, rgb in tour_frames(world):
                encoded, picture = cv2.imencode(
                    ".jpg", cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, 90]
                )
                assert encoded
                answer = client.post(
                    f"{ports.url('inference')}/detect",
                    content=picture.tobytes(),
                    headers={"content-type": "image/jpeg"},
                ).raise_for_status()
                seen = Detections.model_validate_json(answer.content).detections
                stored += _remember(client, ports, estimate.pose, seen)
                frames += 1
                on_frame(frames)
    finally:
        world.close()
    return frames, stored


def _remember(client: httpx.Client, ports: Ports, pose: Pose2D, seen: tuple[Detection, ...]) -> int:
    observations = tuple(
        Observation(label=d.label, confidence=d.confidence, colour=d.colour, pose=pose, stamp_s=time.time())
        for d in seen
    )
    if not observations:
        return 0
    answer = client.post(
        f"{ports.url('memory')}/observations",
        content=ObservationBatch(observations=observations).model_dump_json(),
        headers={"content-type": "application/json"},
    ).raise_for_status()
    return ObservationsReply.model_validate_json(answer.content).stored
