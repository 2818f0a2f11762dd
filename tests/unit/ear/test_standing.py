"""The mission stands while the ear listens, understands and speaks: held again in time, and let go once."""

import contextlib
from collections.abc import AsyncGenerator
from dataclasses import dataclass, field

from ear.messages import Hold, LetGo
from ear.standing import STANDS_S, Standing
from mesh.tasks import Tasks
from support.ear_fakes import FOUND, RUNNING, FakeCoordinator
from support.fake_clock import FakeClock

HOLD_S = 30.0
NEXT = RUNNING.model_copy(update={"id": "m2"})


@dataclass
class Held:
    coordinator: FakeCoordinator = field(default_factory=lambda: FakeCoordinator(running=RUNNING))
    clock: FakeClock = field(default_factory=FakeClock)
    standing: Standing = field(init=False)
    tasks: Tasks = field(init=False)

    @contextlib.asynccontextmanager
    async def running(self) -> AsyncGenerator["Held"]:
        died: list[str] = []
        async with Tasks(on_death=lambda: died.append("a task died")) as self.tasks:
            self.standing = Standing(self.coordinator, self.clock, HOLD_S)
            self.tasks.start("hold", self.standing.hold_and_let_go())
            self.tasks.start("hold again", self.standing.keep_renewing())
            yield self
        assert died == []

    async def take(self, *actions: Hold | LetGo) -> None:
        for action in actions:
            self.standing.take(action)
        await self.clock.settle()

    @property
    def asked(self) -> list[tuple[str, float]]:
        return list(zip(self.coordinator.held, self.coordinator.holds, strict=True))


async def test_it_is_held_again_well_before_it_would_go_on_and_only_while_it_is_to_stand() -> None:
    async with Held().running() as held:
        await held.take(Hold())
        await held.clock.advance(HOLD_S)
        assert held.coordinator.holds == [HOLD_S] * 4
        await held.take(LetGo())
        await held.clock.advance(2 * HOLD_S)
        assert held.coordinator.holds == [*[HOLD_S] * 4, 0.0]


async def test_a_mission_that_begins_meanwhile_stands_at_once() -> None:
    async with Held().running() as held:
        await held.take(Hold())
        held.coordinator.running = NEXT
        held.standing.again()
        await held.clock.settle()
        await held.take(LetGo())
        assert held.asked == [("m1", HOLD_S), ("m2", HOLD_S), ("m2", 0.0)]


async def test_a_mission_that_begins_while_nothing_is_to_stand_is_not_held() -> None:
    async with Held().running() as held:
        held.standing.again()
        await held.clock.advance(HOLD_S)
        assert held.asked == []


async def test_a_hold_whose_answer_was_lost_is_given_back_all_the_same() -> None:
    async with Held().running() as held:
        held.coordinator.obeys.clear()
        await held.take(Hold())
        held.coordinator.away = True
        held.coordinator.obeys.set()
        await held.clock.settle()
        held.coordinator.away = False
        await held.take(LetGo())
        assert held.asked == [("m1", HOLD_S), ("m1", 0.0)]


async def test_what_has_ended_or_was_paused_by_a_person_is_left_alone() -> None:
    for mission in (None, FOUND, RUNNING.model_copy(update={"paused": True})):
        async with Held(FakeCoordinator(running=mission)).running() as held:
            await held.take(Hold(), LetGo())
            assert held.asked == []


async def test_a_sentence_waits_until_the_mission_stands_but_not_for_ever() -> None:
    async with Held().running() as held:
        held.coordinator.obeys.clear()
        await held.take(Hold())
        waiting = held.tasks.start("sentence", held.standing.before_a_sentence(), forever=False)
        await held.clock.advance(STANDS_S - 0.1)
        assert not waiting.done()
        held.coordinator.obeys.set()
        await held.clock.settle()
        assert waiting.done()
        held.coordinator.obeys.clear()
        await held.take(Hold())
        late = held.tasks.start("sentence", held.standing.before_a_sentence(), forever=False)
        await held.clock.advance(STANDS_S)
        assert late.done()
