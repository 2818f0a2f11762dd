"""Whether the robot may move, as the ear knows it from the timeline, and what it says of how missions ended."""

import contextlib
from collections.abc import AsyncGenerator
from dataclasses import dataclass, field

import pytest

from contracts.mission import EventKind, Mission, MissionState, MissionStatus
from ear.following import AGAIN_S, Following, may_move
from ear.ports import Line
from mesh.tasks import Tasks
from support.ear_fakes import FOUND, RUNNING, FakeCoordinator
from support.fake_clock import FakeClock

WAITING = RUNNING.model_copy(update={"id": "m2", "queue_position": 1})


@dataclass
class Followed:
    coordinator: FakeCoordinator = field(default_factory=FakeCoordinator)
    clock: FakeClock = field(default_factory=FakeClock)
    begun: int = 0
    said: list[str] = field(default_factory=list[str])
    following: Following = field(init=False)

    @contextlib.asynccontextmanager
    async def running(self) -> AsyncGenerator["Followed"]:
        died: list[str] = []
        async with Tasks(on_death=lambda: died.append("a task died")) as tasks:
            self.following = Following(self.coordinator, self.clock, tasks, begun=self._begun, ended=self.said.append)
            assert self.following.may_move, "nobody knows yet"
            tasks.start("follow", self.following.follow())
            tasks.start("may it move", self.following.keep_sure())
            await self.clock.settle()
            yield self
        assert died == []

    def _begun(self) -> None:
        self.begun += 1

    async def happens(self, *kinds: EventKind, state: MissionState = MissionState.IDLE) -> None:
        for kind in kinds:
            self.coordinator.happens(kind, self.clock.now_s(), state)
        await self.clock.settle()

    async def line(self, line: Line) -> None:
        self.coordinator.happened.put_nowait(line)
        await self.clock.settle()


async def test_a_robot_that_does_nothing_does_not_move() -> None:
    async with Followed().running() as followed:
        assert not followed.following.may_move


async def test_until_the_coordinator_answers_the_robot_may_move_and_it_is_asked_again() -> None:
    async with Followed(FakeCoordinator(away=True)).running() as followed:
        assert followed.following.may_move
        followed.coordinator.away = False
        await followed.clock.advance(AGAIN_S)
        assert not followed.following.may_move


async def test_a_mission_that_begins_is_told_and_may_move_the_robot() -> None:
    async with Followed().running() as followed:
        followed.coordinator.running = RUNNING
        await followed.happens(EventKind.START, state=MissionState.MEMORY_NAV)
        assert (followed.following.may_move, followed.begun) == (True, 1)


async def test_the_end_of_a_mission_that_waits_ends_nothing_of_the_one_that_runs() -> None:
    async with Followed(FakeCoordinator(running=RUNNING)).running() as followed:
        followed.coordinator.says_how_it_is.clear()
        await followed.happens(EventKind.END, state=MissionState.MEMORY_NAV)
        assert followed.following.may_move, "as long as nobody said that it stands"
        followed.coordinator.says_how_it_is.set()
        await followed.clock.settle()
        assert followed.following.may_move


async def test_when_its_mission_has_ended_it_does_not_move() -> None:
    async with Followed(FakeCoordinator(running=RUNNING)).running() as followed:
        followed.coordinator.running = FOUND
        await followed.happens(EventKind.END)
        assert not followed.following.may_move


async def test_after_a_find_it_may_move_until_it_has_celebrated() -> None:
    async with Followed(FakeCoordinator(running=RUNNING)).running() as followed:
        followed.coordinator.running, followed.coordinator.state = FOUND, MissionState.DONE
        await followed.happens(EventKind.FOUND, state=MissionState.DONE)
        assert followed.following.may_move
        followed.coordinator.state = MissionState.IDLE
        await followed.happens(EventKind.STATE)
        assert not followed.following.may_move
        assert followed.said == ["I found the red bottle."]


async def test_while_the_timeline_is_away_it_may_move_whatever_was_last_known() -> None:
    async with Followed().running() as followed:
        await followed.line(Line.BROKEN)
        assert followed.following.may_move
        await followed.clock.advance(AGAIN_S)
        assert followed.following.may_move, "what is said of it may be over before the line is back"
        await followed.line(Line.OPEN)
        assert not followed.following.may_move


async def test_a_mission_that_began_while_the_timeline_was_away_is_asked_for_when_it_is_back() -> None:
    async with Followed().running() as followed:
        await followed.line(Line.BROKEN)
        followed.coordinator.running = RUNNING
        await followed.line(Line.OPEN)
        assert followed.following.may_move


async def test_what_was_asked_before_a_mission_began_is_not_believed_after_it() -> None:
    async with Followed(FakeCoordinator(running=RUNNING)).running() as followed:
        followed.coordinator.says_how_it_is.clear()
        followed.coordinator.running = None
        await followed.happens(EventKind.END)
        followed.coordinator.running = RUNNING
        await followed.happens(EventKind.START)
        followed.coordinator.says_how_it_is.set()  # to the one that was asked first
        followed.coordinator.says_how_it_is.clear()
        await followed.clock.settle()
        assert followed.following.may_move


async def test_a_record_that_comes_late_holds_up_nothing() -> None:
    async with Followed().running() as followed:
        followed.coordinator.tells.clear()
        followed.coordinator.running = RUNNING
        await followed.happens(EventKind.FOUND, EventKind.START)
        assert followed.following.may_move
        assert followed.begun == 1
        followed.coordinator.tells.set()
        await followed.clock.settle()
        assert followed.said == ["I found the red bottle."]


@pytest.mark.parametrize(
    ("mission", "state", "queue", "moves"),
    [
        (None, MissionState.IDLE, (), False),
        (FOUND, MissionState.IDLE, (), False),
        (FOUND, MissionState.DONE, (), True),
        (FOUND, MissionState.IDLE, (WAITING,), True),
        (RUNNING, MissionState.MEMORY_NAV, (), True),
        (FOUND, MissionState.EMERGENCY_STOP, (), False),
    ],
)
def test_it_may_move_while_a_mission_runs_waits_or_is_celebrated(
    mission: Mission | None, state: MissionState, queue: tuple[Mission, ...], moves: bool
) -> None:
    assert may_move(MissionStatus(stamp_s=1.0, state=state, mission=mission, queue=queue)) is moves
