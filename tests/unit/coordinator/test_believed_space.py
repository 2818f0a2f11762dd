"""The shell's side of the belief: every look is told once, whatever was cancelled."""

import asyncio
import math
import threading
from contextlib import suppress

import numpy as np
import pytest

from contracts.geometry import Pose2D
from contracts.vision import Detections, Target
from coordinator.belief.belief_map import BeliefMap, Glance
from coordinator.core.actions import PlanCoverage
from coordinator.execution.believed_space import BelievedSpace
from geometry.grids import OccupancyGrid
from geometry.probability_grids import decode
from support.described import DESCRIPTION
from support.mission_script import rules_of

HERE = Pose2D(x=1.0, y=1.0, yaw=0.0)
GRID = OccupancyGrid(np.zeros((40, 40), dtype=np.int8), 0.05, Pose2D(x=0.0, y=0.0, yaw=0.0))
ANYWHERE = PlanCoverage(1, (), 20.0)
NOTHING = Detections(stamp_s=1.0, image_width_px=250, image_height_px=250, detections=())


async def test_a_robot_that_stops_beside_what_it_chose_is_not_sent_there_for_ever() -> None:
    """It stands a little beside the place and turned a little beside the heading, so it sees other cells than those it
    was sent for.
    """
    cells = np.zeros((60, 100), dtype=np.int8)
    cells[:2], cells[-2:], cells[:, :2], cells[:, -2:], cells[20:40, 50:54] = 100, 100, 100, 100, 100
    grid, here = OccupancyGrid(cells, 0.05, Pose2D(x=0.0, y=0.0, yaw=0.0)), HERE
    space = BelievedSpace(rules_of(), DESCRIPTION, Target(label="cup", description="red cup"), ())
    chosen = list[tuple[Pose2D, tuple[float, ...]]]()
    for _ in range(80):
        view = (await space.choose(grid, here, ANYWHERE)).view
        if view is None:
            break
        chosen.append((view.pose, view.headings))
        if math.hypot(view.pose.x - here.x, view.pose.y - here.y) > 0.3:  # else it stays where it is
            here = Pose2D(x=view.pose.x - 0.2, y=view.pose.y - 0.2, yaw=view.pose.yaw)
        for heading in view.headings:
            here = here.model_copy(update={"yaw": heading - 0.06})
            space.look(here, NOTHING)
    else:
        pytest.fail(f"{len(chosen)} views and no end: {chosen[-2:]}")
    assert len(set(chosen)) == len(chosen)


async def chosen_after(space: BelievedSpace, grid: OccupancyGrid, *, moving: bool) -> tuple[Pose2D, ...]:
    """The first view chosen, and the next one after a look from beside it that shows little of it."""
    first = (await space.choose(grid, HERE, ANYWHERE)).view
    assert first is not None
    beside = first.pose.model_copy(update={"x": first.pose.x + 0.45})
    for heading in first.headings:
        space.look(beside.model_copy(update={"yaw": heading - 0.3}), NOTHING, moving=moving)
    second = (await space.choose(grid, HERE, ANYWHERE)).view
    assert second is not None
    return first.pose, second.pose


def home() -> OccupancyGrid:
    cells = np.zeros((60, 100), dtype=np.int8)
    cells[:2], cells[-2:], cells[:, :2], cells[:, -2:], cells[20:40, 50:54] = 100, 100, 100, 100, 100
    return OccupancyGrid(cells, 0.05, Pose2D(x=0.0, y=0.0, yaw=0.0))


@pytest.mark.parametrize("moving", [True, False])
async def test_what_is_seen_in_passing_is_not_the_look_that_was_chosen(
    monkeypatch: pytest.MonkeyPatch, moving: bool
) -> None:
    spent = list[Pose2D]()

    def spend(_: BeliefMap, pose: Pose2D, hfov_rad: float) -> None:
        spent.append(pose)

    monkeypatch.setattr(BeliefMap, "spend", spend)
    space = BelievedSpace(rules_of(), DESCRIPTION, Target(label="cup", description="red cup"), ())
    await chosen_after(space, home(), moving=moving)
    assert bool(spent) is not moving


async def test_a_new_map_forgets_no_look_that_was_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    told, spent = list[Pose2D](), list[Pose2D]()

    def look(_: BeliefMap, glance: Glance) -> None:
        told.append(glance.pose)

    def spend(_: BeliefMap, pose: Pose2D, hfov_rad: float) -> None:
        spent.append(pose)

    monkeypatch.setattr(BeliefMap, "look", look)
    monkeypatch.setattr(BeliefMap, "spend", spend)
    space = BelievedSpace(rules_of(), DESCRIPTION, Target(label="cup", description="red cup"), ())
    await chosen_after(space, home(), moving=False)
    before = tuple(told), tuple(spent)
    await space.choose(home(), HERE, ANYWHERE)
    assert (tuple(told), tuple(spent)) == (before[0] * 2, before[1] * 2)


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
    cancelled = asyncio.create_task(space.choose(GRID, HERE, ANYWHERE))
    assert await asyncio.to_thread(began.wait, 10.0)
    cancelled.cancel()
    with suppress(asyncio.CancelledError):
        await cancelled
    began.clear()
    again = asyncio.create_task(space.choose(GRID, HERE, ANYWHERE))
    assert not await asyncio.to_thread(began.wait, 0.2)
    go_on.set()
    await again
    assert told == [HERE]


async def test_before_the_first_choice_there_is_nothing_to_report() -> None:
    space = BelievedSpace(rules_of(), DESCRIPTION, Target(label="cup", description="red cup"), ())
    space.look(HERE, NOTHING)
    assert await space.report("m-1", "home", 1.0) is None


async def test_a_report_holds_every_look_so_far_and_whoever_asks_changes_no_choice() -> None:
    asked, not_asked = (
        BelievedSpace(rules_of(), DESCRIPTION, Target(label="cup", description="red cup"), ()) for _ in range(2)
    )
    for space in (asked, not_asked):
        await space.choose(GRID, HERE, ANYWHERE)
    before = await asked.report("m-1", "home", 1.0)
    for space in (asked, not_asked):
        space.look(HERE, NOTHING)
    after = await asked.report("m-1", "home", 2.0)
    assert before is not None
    assert after is not None
    assert (after.mission_id, after.map_id, after.stamp_s) == ("m-1", "home", 2.0)
    assert after.absent > before.absent
    assert decode(after.grid).sum() + after.absent == pytest.approx(1.0, abs=0.02)
    cell_before, cell_after = (decode(one.grid)[6, 12] for one in (before, after))  # 0.9 m ahead
    assert cell_after < 0.5 * cell_before
    assert await asked.choose(GRID, HERE, ANYWHERE) == await not_asked.choose(GRID, HERE, ANYWHERE)


async def test_a_report_tells_the_view_that_was_chosen_and_why() -> None:
    space = BelievedSpace(rules_of(), DESCRIPTION, Target(label="cup", description="red cup"), ())
    choice = await space.choose(GRID, HERE, ANYWHERE)
    report = await space.report("m-1", None, 1.0)
    assert choice.view is not None
    assert report is not None
    assert report.view is not None
    assert (report.view.pose, report.view.headings, report.why) == (choice.view.pose, choice.view.headings, choice.why)
