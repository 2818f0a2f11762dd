"""What memory, the missions and the robot know of what is asked: records, and a sentence that leads to them (shell)."""

from collections.abc import Sequence
from http import HTTPStatus

import structlog

from contracts.asking import About, Record
from contracts.exploration import Discovery
from contracts.memory import RememberedObject, View
from contracts.mission import Mission, MissionKind
from contracts.rooms import NamedRoom
from coordinator.core.report import ago
from coordinator.execution.mission_runner import MissionRunner
from coordinator.ports import Memory, MissionLog
from coordinator.questions.parsed_question import ParsedQuestion
from coordinator.questions.rooms_meant import KnownRooms, inside
from coordinator.questions.tallies import THERE, apart_m, changes, tally
from coordinator.settings import Settings
from mesh.clock import Clock
from mesh.errors import UpstreamError
from vocabulary.groups import Group
from vocabulary.rooms import ROOMS, called

log = structlog.get_logger()

RECORDS_MAX = 12
OBJECTS_ASKED = 200
ROOM_M = 3.0
DAY_S = 86400.0
HELP = (
    "I can say where I last saw a thing, how many there are, what changed, what is in a room, what I am doing, what I "
    "did, what I discovered, and how full the battery is."
)


class QuestionFacts:
    """Made anew for each question, with the rooms that it was asked among."""

    def __init__(
        self,
        rooms: KnownRooms,
        *,
        settings: Settings,
        memory: Memory,
        log_: MissionLog,
        runner: MissionRunner,
        clock: Clock,
    ) -> None:
        self._rooms = rooms
        self._settings = settings
        self._memory = memory
        self._log = log_
        self._runner = runner
        self._clock = clock

    async def of(self, asked: ParsedQuestion) -> tuple[Sequence[Record], str]:  # noqa: PLR0911 - one for each topic
        """The records, and the sentence that leads to them. Raises `MeshError` where what must be asked is away."""
        match asked.about:
            case About.LAST_SEEN if asked.label is not None:
                return await self._last_seen(asked)
            case About.LAST_SEEN:
                return (), "That is nothing my eyes can tell from other things. " + HELP
            case About.CONTENTS if asked.group is not None:
                return await self._of_group(asked, asked.group)
            case About.CONTENTS:
                return await self._contents(asked)
            case About.COUNT:
                return await self._count(asked)
            case About.CHANGES:
                return await self._changes(asked)
            case About.DOING:
                return self._doing(), "Now:"
            case About.DISCOVERIES:
                return await self._discoveries()
            case About.HISTORY:
                return await self._history(asked)
            case About.BATTERY:
                return self._battery()
            case About.UNKNOWN:
                return (), HELP

    async def _last_seen(self, asked: ParsedQuestion) -> tuple[Sequence[Record], str]:
        what = f"{asked.colour} {asked.label}" if asked.colour else f"{asked.label}"
        things = [one for one in await self._objects(asked.label) if _colour_fits(one.colour, asked.colour)]
        found = [self._of_object(one) for one in sorted(things, key=lambda one: -one.last_seen_s)]
        if not found:
            views = [
                v for v in await self._memory.views(asked.label or "", 100) if _colour_fits(v.colour, asked.colour)
            ]
            found = [self._of_view(one) for one in sorted(views, key=lambda one: -one.stamp_s)]
        if not found:
            return (), f"I have not seen a {what}."
        return found[:3], f"The last time I saw a {what}:"

    async def _contents(self, asked: ParsedQuestion) -> tuple[Sequence[Record], str]:
        if asked.room is None:
            things = await self._objects(None)
            if things:
                return [self._of_object(one) for one in things[:RECORDS_MAX]], "I remember:"
            counts = await self._memory.labels()
            known = [Record(source="memory", text=f"{one.label}: seen from {one.views} places", label=one.label,
                            stamp_s=one.last_seen_s) for one in counts[:RECORDS_MAX]]  # fmt: skip
            return known, "I remember:" if known else "I remember nothing yet."
        meant = self._rooms.meant(asked.room)
        if meant:
            there = await self._in_rooms(None, meant)
            where = " and ".join(called(one.name) for one in meant)
            lead = f"In {where}:" if there else f"I remember nothing in {where}."
            return [self._of_object(one) for one in there[:RECORDS_MAX]], lead
        if asked.room not in ROOMS:
            return (), f"I know no room called {asked.room}."
        things = await self._objects(None)
        marks = [one for one in things if one.label in ROOMS[asked.room]]
        if not marks:
            return (), f"I do not know where the {asked.room} is: I have seen none of {', '.join(ROOMS[asked.room])}."
        named = ", ".join(sorted({one.label for one in marks}))
        near = _near_any(things, marks)
        return [self._of_object(one) for one in near[:RECORDS_MAX]], f"Within {ROOM_M:.0f} m of the {named}:"

    async def _of_group(self, asked: ParsedQuestion, group: Group) -> tuple[Sequence[Record], str]:
        things = [one for one in await self._there(asked) if one.label in group.labels]
        if not things:
            return (), f"I remember nothing of that kind ({group.name}: {', '.join(group.labels)})."
        return [self._of_object(one) for one in things[:RECORDS_MAX]], f"I remember ({group.name}):"

    async def _count(self, asked: ParsedQuestion) -> tuple[Sequence[Record], str]:
        labels = (asked.label,) if asked.label is not None else asked.group.labels if asked.group is not None else ()
        if not labels:
            return (), "That is nothing my eyes can tell from other things. " + HELP
        what = f"{asked.colour} {labels[0]}" if asked.colour and asked.label else asked.label or ", ".join(labels)
        every = [one for one in await self._objects(asked.label) if one.label in labels]
        if not every:
            counts = [one for one in await self._memory.labels() if one.label in labels]
            seen = "; ".join(f"{one.label}: seen from {one.views} places" for one in counts)
            return (), f"I cannot count them ({what}). {seen}." if seen else f"I remember none ({what})."
        near = [one for one in await self._of_room(asked.label, asked.room) if one.label in labels]
        there = [one for one in near if one.state in THERE and _colour_fits(one.colour, asked.colour)]
        newest = sorted(there, key=lambda one: -one.last_seen_s)
        return [self._of_object(one) for one in newest[:RECORDS_MAX]], tally(near, what, asked.colour)

    async def _changes(self, asked: ParsedQuestion) -> tuple[Sequence[Record], str]:
        since_s = self._clock.now_s() - asked.days * DAY_S
        things = [one for one in await self._objects(asked.label) if _colour_fits(one.colour, asked.colour)]
        found = changes(things, since_s)
        days = asked.days
        span = "In the last " + ("hour" if days < 1.0 else "day" if days == 1.0 else f"{days:.0f} days")
        records = [
            (record := self._of_object(one)).model_copy(update={"text": f"{what}: {record.text}"[:300]})
            for what, one in found[:RECORDS_MAX]
        ]
        return records, f"{span} I noticed {len(found)} changes:" if found else f"{span} I noticed no change."

    async def _there(self, asked: ParsedQuestion) -> list[RememberedObject]:
        things = await self._of_room(None, asked.room)
        return [one for one in things if one.state in THERE and _colour_fits(one.colour, asked.colour)]

    async def _of_room(self, label: str | None, room: str | None) -> list[RememberedObject]:
        """Of the whole home where no room is meant; where memory does not know the room, what lies near the things that
        make one of its kind."""
        if room is not None and (meant := self._rooms.meant(room)):
            return await self._in_rooms(label, meant)
        things = await self._objects(label)
        if room is None:
            return things
        return _near_any(things, [one for one in await self._objects(None) if one.label in ROOMS.get(room, ())])

    async def _in_rooms(self, label: str | None, rooms: Sequence[NamedRoom]) -> list[RememberedObject]:
        """Likeliest first; of each room as many as are asked for, however much the home holds."""
        found = [one for room in rooms for one in inside(await self._objects(label, room.id), [room])]
        return sorted(found, key=lambda one: -one.belief)

    async def _objects(self, label: str | None, room_id: int | None = None) -> list[RememberedObject]:
        """What is thought to be there still, likeliest first; none from a memory that knows views only."""
        try:
            found = await self._memory.objects(label, OBJECTS_ASKED, room_id)
        except UpstreamError as error:
            if error.upstream_status != HTTPStatus.NOT_FOUND:
                raise
            log.debug("memory names no objects", reason=error.detail)
            return []
        return sorted(found, key=lambda one: -one.belief)

    def _doing(self) -> list[Record]:
        status = self._runner.status()
        mission = status.mission
        if mission is None or (mission.outcome is not None and status.state.value == "IDLE"):
            first = Record(source="robot", text="I am doing nothing and wait for a command")
        else:
            stands = mission.paused and not self._runner.mission.listening  # to hear the question, as a rule
            word = "paused" if stands else status.state.value.lower().replace("_", " ")
            text = f"'{mission.command}': {word}; {status.progress}"
            first = Record(source="mission", id=mission.id, text=text[:300], stamp_s=mission.started_s)
        waiting = [Record(source="queue", id=one.id, text=f"'{one.command}' waits"[:300]) for one in status.queue]
        return [first, *waiting][:RECORDS_MAX]

    async def _discoveries(self) -> tuple[Sequence[Record], str]:
        found = [self._of_discovery(one) for one in reversed(await self._runner.discovered())]
        return found[:RECORDS_MAX], "I discovered:" if found else "I have discovered nothing in this home yet."

    async def _history(self, asked: ParsedQuestion) -> tuple[Sequence[Record], str]:
        missions = [one for one in await self._log.newest(50) if one.outcome is not None]
        if asked.label is not None:
            missions = [one for one in missions if one.target is not None and one.target.label == asked.label]
        found = [self._of_mission(one) for one in missions[:5]]
        return found, "My last missions:" if found else "I have done no such mission."

    def _battery(self) -> tuple[Sequence[Record], str]:
        state = self._runner.robot_state
        if (
            state is None
            or state.battery is None
            or state.battery.percentage is None
            or self._runner.robot_state_age_s > self._settings.robot_state_age_s_max
        ):
            return (), "I do not know how full the battery is: the robot says nothing of it."
        charging = ", and charging" if state.battery.charging else ""
        docked = {True: ", on the dock", False: ", not on the dock", None: ""}[state.docked]
        text = f"the battery is at {state.battery.percentage:.0f} %{charging}{docked}"
        return (Record(source="robot", text=text, stamp_s=state.stamp_s),), "Power:"

    # records

    def _of_object(self, one: RememberedObject) -> Record:
        text = (
            f"{one.description} at x {one.position.x:.1f} m, y {one.position.y:.1f} m, "
            f"seen {self._ago(one.last_seen_s)}, {one.state.value}{self._rooms.where(one)}"
        )
        return Record(source="memory", id=f"object {one.id}", text=text, label=one.label, stamp_s=one.last_seen_s)

    def _of_view(self, one: View) -> Record:
        what = f"{one.colour} {one.label}" if one.colour else one.label
        text = f"{what} seen {self._ago(one.stamp_s)} from x {one.pose.x:.1f} m, y {one.pose.y:.1f} m"
        return Record(source="memory", id=f"view {one.id}", text=text, label=one.label, stamp_s=one.stamp_s,
                      pose=one.pose)  # fmt: skip

    def _of_discovery(self, one: Discovery) -> Record:
        note = f" ({one.note})" if one.note else ""
        text = f"{one.label}{note} at x {one.x_m:.1f} m, y {one.y_m:.1f} m, {self._ago(one.stamp_s)}"
        return Record(source="exploration", text=text[:300], label=one.label, stamp_s=one.stamp_s)

    def _of_mission(self, one: Mission) -> Record:
        ended_s = one.ended_s if one.ended_s is not None else one.started_s
        word = one.outcome.value.replace("_", " ") if one.outcome is not None else "running"
        what = "to the dock" if one.kind is MissionKind.DOCK else f"'{one.command}'"
        text = f"{what}, {self._ago(ended_s)}: {word}; {one.reason}"
        return Record(source="mission", id=one.id, text=text[:300], stamp_s=ended_s)

    def _ago(self, stamp_s: float) -> str:
        return ago(self._clock.now_s() - stamp_s)


def _near_any(things: Sequence[RememberedObject], marks: Sequence[RememberedObject]) -> list[RememberedObject]:
    return [one for one in things if any(apart_m(one, mark) <= ROOM_M for mark in marks)]


def _colour_fits(seen: str | None, asked: str | None) -> bool:
    return asked is None or seen == asked
