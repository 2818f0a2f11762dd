"""What was looked at, on the newest map: read beside the event loop, and no look is lost meanwhile."""

import asyncio
import threading

import pytest

from contracts.geometry import Pose2D
from contracts.robot import Map
from coordinator.coverage import explored_space
from coordinator.coverage.explored_space import READING_TASK, ExploredSpace
from geometry.grids import OccupancyGrid
from support.bus import MemoryBus
from support.coordinator_world import FakeRobot, World
from support.fake_clock import FakeClock
from support.mission_script import rules_of

HERE = Pose2D(x=1.5, y=1.5, yaw=0.0)


async def test_a_look_taken_while_the_map_is_read_is_on_it(monkeypatch: pytest.MonkeyPatch) -> None:
    begun, go_on = threading.Event(), threading.Event()
    threads: list[int] = []
    decode = explored_space.decode

    def slow(message: Map) -> OccupancyGrid:
        threads.append(threading.get_ident())
        begun.set()
        assert go_on.wait(30.0)
        return decode(message)

    monkeypatch.setattr(explored_space, "decode", slow)
    explored = ExploredSpace(FakeRobot(World(clock=FakeClock(), bus=MemoryBus())), rules_of(), None)
    reading = asyncio.create_task(explored.refresh())
    again = asyncio.create_task(explored.refresh())
    await asyncio.to_thread(begun.wait, 30.0)
    assert any(task.get_name() == READING_TASK for task in asyncio.all_tasks())
    assert explored.look(HERE) is None
    go_on.set()
    space = await reading
    assert space.share is not None
    assert space.share > 0.0
    assert await again is space
    assert len(threads) == 1
    assert threads != [threading.get_ident()]
