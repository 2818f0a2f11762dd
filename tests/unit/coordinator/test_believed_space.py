"""The shell's side of the belief: every look is told once, whatever was cancelled."""

import asyncio
import threading
from contextlib import suppress

import numpy as np
import pytest

from contracts.geometry import Pose2D
from contracts.vision import Detections, Target
from coordinator.belief.belief_map import BeliefMap, Glance
from coordinator.execution.believed_space import BelievedSpace
from geometry.grids import OccupancyGrid
from support.described import DESCRIPTION
from support.mission_script import rules_of

HERE = Pose2D(x=1.0, y=1.0, yaw=0.0)
GRID = OccupancyGrid(np.zeros((40, 40), dtype=np.int8), 0.05, Pose2D(x=0.0, y=0.0, yaw=0.0))
NOTHING = Detections(stamp_s=1.0, image_width_px=250, image_height_px=250, detections=())


async def test_a_choice_after_a_cancelled_one_waits_for_it_and_no_look_is_told_twice(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    began, go_on, told = threading.Event(), threading.Event(), list[Pose2D]()

    def look(_: BeliefMap, glance: Glance) -> None:
        told.append(glance.pose)
        began.set()
        assert go_on.wait(10.0)

    monkeypatch.setattr(BeliefMap, "look", look)
    space = BelievedSpace(rules_of(), DESCRIPTION, Target(label="cup", description="red cup"), ())
    space.look(HERE, NOTHING)
    cancelled = asyncio.create_task(space.choose(GRID, HERE, (), ()))
    assert await asyncio.to_thread(began.wait, 10.0)
    cancelled.cancel()
    with suppress(asyncio.CancelledError):
        await cancelled
    began.clear()
    again = asyncio.create_task(space.choose(GRID, HERE, (), ()))
    assert not await asyncio.to_thread(began.wait, 0.2)
    go_on.set()
    await again
    assert told == [HERE]
