"""A story on the simulated home, told to memory frame by frame: what does it recall after each chapter?

The red bottle is seen, hidden, carried off, looked for, found elsewhere, left alone for a month, removed, and at
last brought back. Prints a table; writes out/bench/memory_story.md.
"""

import argparse
import asyncio
import math
import tempfile
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from bench.memory_eyes import Eyes
from bench.world.body import DESCRIPTION
from contracts.geometry import Pose2D
from contracts.memory import RecallRequest
from contracts.vision import Target
from memory.adapters.store import SqlStore
from memory.memory_service import MemoryService
from memory.settings import Settings
from mesh.bus import open_bus
from sim.home import Home, Wanted
from sim.home.model import Thing

RED_BOTTLE = Wanted("bottle", "red")
NEAR_M = 0.6
DAY_S = 86_400.0
START_S = 1.8e9


@dataclass
class HandClock:
    """Goes on by hand; nobody sleeps on it."""

    time_s: float = START_S

    def now_s(self) -> float:
        return self.time_s

    async def sleep(self, seconds: float) -> None:
        raise NotImplementedError("nothing runs in the background of this story")


@dataclass(frozen=True)
class Chapter:
    """One row of the table: `wanted` and `recalled` are names of places, or "nowhere"."""

    happened: str
    wanted: str
    recalled: str
    known: str
    seconds: float

    @property
    def right(self) -> bool:
        return self.wanted == self.recalled


class Story:
    """The home, the robot's eyes, and memory; places have names."""

    def __init__(self, eyes: Eyes, memory: MemoryService, clock: HandClock) -> None:
        self.eyes = eyes
        self.memory = memory
        self.clock = clock
        self.places: dict[str, tuple[float, float]] = {}
        self.chapters: list[Chapter] = []

    async def look(self, pose: Pose2D, frames: int = 3) -> None:
        """Stands there for some frames, half a second apart; perception's message goes the way it always goes."""
        self.eyes.pose = pose
        for _ in range(frames):
            self.clock.time_s += 0.5
            await self.memory.take(self.eyes.frame(self.clock.time_s))
            await self.memory.catch_up()

    async def tell(self, happened: str, wanted: str) -> None:
        reply = await self.memory.recall(RecallRequest(target=Target(label="bottle", description="red bottle")))
        red = [one for one in reply.views if one.thing is None or one.thing.colour == "red"]
        best = red[0] if red else None
        place = "nowhere"
        if best is not None and best.thing is not None:
            place = self._named(best.thing.position.x, best.thing.position.y)
        elif best is not None:
            place = "a view without a place"
        things = await self.memory.objects("bottle", None, "red", 10)
        known = ", ".join(f"{self._named(o.position.x, o.position.y)}: {o.state.value} {o.belief:.2f}" for o in things)
        self.chapters.append(Chapter(happened, wanted, place, known, self.clock.time_s - START_S))

    def _named(self, x: float, y: float) -> str:
        near = [name for name, (px, py) in self.places.items() if math.hypot(x - px, y - py) < NEAR_M]
        return near[0] if near else f"({x:.1f}, {y:.1f})"


async def tell(story: Story) -> None:
    """Every chapter; the truth of the home changes only while the robot looks elsewhere."""
    eyes, clock = story.eyes, story.clock
    bottle = red_bottle(eyes)
    others = tuple(one for one in eyes.truth.things if one.id != bottle.id)
    first, second = eyes.places_to_see(bottle, away_m=1.4, apart_m=0.5, count=2)
    table = (bottle.x_m, bottle.y_m)
    story.places["the first place"] = table

    await story.look(first)
    await story.tell("seen from one place", "the first place")
    await story.look(turned(first, math.pi))
    await story.tell("looked the other way", "the first place")

    eyes.change((*others, bottle, screen(first, table)))
    await story.look(first, frames=6)
    await story.tell("looked at, but something stands in between", "the first place")

    eyes.change((*others, bottle))
    stand_in, _ = new_place(eyes, others, table)
    moved = replace(bottle, x_m=stand_in.x_m, y_m=stand_in.y_m, z_m=stand_in.z_m, support=stand_in.support)
    left = tuple(one for one in others if one.id != stand_in.id)
    eyes.change((*left, moved))
    clock.time_s += 3600.0
    await story.tell("carried off, which nobody saw", "the first place")
    await story.look(first)
    await story.tell("looked for from one place: not there, doubtful", "the first place")
    await story.look(second)
    await story.tell("looked for from a second place: lost", "nowhere")

    story.places["the second place"] = (moved.x_m, moved.y_m)
    near, other_side = eyes.places_to_see(moved, away_m=1.4, apart_m=0.5, count=2)
    await story.look(near)
    await story.tell("found elsewhere", "the second place")
    clock.time_s += 30.0 * DAY_S
    await story.tell("a month later", "the second place")

    eyes.change(left)
    await story.look(near)
    await story.look(other_side)
    await story.tell("removed, and looked for from two places", "nowhere")

    eyes.change((*left, bottle))
    await story.look(first)
    await story.tell("back in its first place", "the first place")


def turned(pose: Pose2D, by_rad: float) -> Pose2D:
    return Pose2D(x=pose.x, y=pose.y, yaw=math.remainder(pose.yaw + by_rad, 2.0 * math.pi))


def screen(pose: Pose2D, behind: tuple[float, float]) -> Thing:
    """Something tall on the floor, half a metre before the robot, on the line to what it is to hide."""
    bearing = math.atan2(behind[1] - pose.y, behind[0] - pose.x)
    return Thing(
        id="screen",
        kind="suitcase",
        colour="black",
        x_m=pose.x + 0.6 * math.cos(bearing),
        y_m=pose.y + 0.6 * math.sin(bearing),
        z_m=0.0,
        yaw=bearing + math.pi / 2.0,
        size_m=(0.5, 0.2, 1.0),
        support="floor",
    )


def new_place(eyes: Eyes, others: tuple[Thing, ...], before: tuple[float, float]) -> tuple[Thing, list[Pose2D]]:
    """Another thing, two metres off or more, that can be seen from two places: the bottle takes its place."""
    for one in others:
        far = math.hypot(one.x_m - before[0], one.y_m - before[1]) > 2.0
        if far and one.kind in {"cup", "bowl", "vase", "book", "apple", "orange"} and one.z_m < 0.8:
            places = eyes.places_to_see(one, away_m=1.4, apart_m=0.5, count=2)
            if len(places) == 2:
                return one, places
    raise LookupError("this home has no second place for a bottle")


@asynccontextmanager
async def beginning(folder: Path, seed: int) -> AsyncIterator[Story]:
    """The first home, from this seed on, whose bottle and whose second place can be seen from two sides."""
    clock = HandClock()
    settings = Settings(database_url=f"sqlite:///{folder}/memory.db")
    store = SqlStore.from_settings(settings)
    eyes = _home(seed)
    try:
        async with open_bus("redis://127.0.0.1:1/0") as bus:
            memory = MemoryService(settings, store, bus, clock, eyes)
            await memory.describe(DESCRIPTION)
            yield Story(eyes, memory, clock)
    finally:
        await eyes.aclose()
        await store.aclose()


def _home(seed: int) -> Eyes:
    for number in range(seed, seed + 50):
        eyes = Eyes(Home.generate(number, wanted=RED_BOTTLE), seed=number)
        bottle = red_bottle(eyes)
        others = tuple(one for one in eyes.truth.things if one.id != bottle.id)
        try:
            new_place(eyes, others, (bottle.x_m, bottle.y_m))
        except LookupError:
            continue
        if len(eyes.places_to_see(bottle, away_m=1.4, apart_m=0.5, count=2)) == 2:
            return eyes
    raise LookupError("no such home")


def red_bottle(eyes: Eyes) -> Thing:
    return next(one for one in eyes.truth.things if (one.kind, one.colour) == ("bottle", "red"))


def table_of(chapters: list[Chapter]) -> str:
    lines = [
        "| what happened | recall should say | recall says | red bottles known (state, belief) |",
        "|---|---|---|---|",
    ]
    for one in chapters:
        mark = "" if one.right else " (wrong)"
        lines.append(f"| {one.happened} | {one.wanted} | {one.recalled}{mark} | {one.known} |")
    return "\n".join(lines) + "\n"


async def told(folder: Path, seed: int) -> list[Chapter]:
    async with beginning(folder, seed) as story:
        await tell(story)
        return story.chapters


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=0, help="of the home; the next one where it does not fit the story")
    parser.add_argument("--out", type=Path, default=Path("out/bench"))
    parser.add_argument("--quick", action="store_true", help="it is quick anyway")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        chapters = asyncio.run(told(Path(folder), arguments.seed))
    table = table_of(chapters)
    arguments.out.mkdir(parents=True, exist_ok=True)
    (arguments.out / "memory_story.md").write_text(table, encoding="utf-8")
    print(table)  # noqa: T201
    raise SystemExit(0 if all(one.right for one in chapters) else 1)


if __name__ == "__main__":
    main()
