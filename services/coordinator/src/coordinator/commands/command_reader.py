"""From a person's words to what is wanted: the parser asked, each of its claims checked, the action read."""

import asyncio
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass, replace
from http import HTTPStatus

import structlog

from contracts.intent import Intent, Understood, WantedAction
from contracts.memory import RememberedObject
from contracts.mission import CommandRefusal
from contracts.reading import Mood, Restriction, RestrictionKind
from contracts.vision import ParsedTask, ParseTaskRequest, Target
from coordinator.commands.abilities import what_it_cannot
from coordinator.commands.plain_motions import one_room_meant, way_to
from coordinator.commands.readings import GRAVEST, NOT_UNDERSTOOD, HeardIntent, understood, uses_all_colours
from coordinator.commands.where_to_look import (
    UnknownRoomError,
    means_the_last,
    not_of_a_room,
    rooms_meant,
    rooms_said,
)
from coordinator.core.motions import PlainMotion
from coordinator.ports import Inference, Memory
from coordinator.questions.parsed_question import parse_question
from coordinator.questions.rooms_meant import KnownRooms
from coordinator.queue.parse_validation import CheckedTask, check_parse
from coordinator.settings import Settings
from mesh.errors import MeshError, UnavailableError, UnprocessableError, UpstreamError
from vocabulary.actions import action_in, is_docking
from vocabulary.folding import words_of
from vocabulary.languages import is_foreign
from vocabulary.moods import Reading, read
from vocabulary.orders import order_in
from vocabulary.restrictions import restrictions_in
from vocabulary.rooms import ROOMS, may_say_where, named_in, room_in, searched_in, speaks_of_a_place, without_neighbours
from vocabulary.sounding import HeardText, by_ear, said_once

log = structlog.get_logger()

LastTarget = Callable[[], Awaitable[Target | None]]
"""What was asked for last; none where nothing was."""

OBJECTS_ASKED = 200
QUESTIONS = {Mood.QUESTION: WantedAction.ASK, Mood.COUNT: WantedAction.COUNT}


@dataclass(frozen=True, slots=True)
class _Claims:
    """What the parser said, checked."""

    found: tuple[CheckedTask, ...]
    said: tuple[str, ...]
    """The words that ask for each of them."""
    unknown: tuple[str, ...]
    parsed: ParsedTask
    note: str
    """What memory could not say."""

    @property
    def unknown_named(self) -> bool:
        """A thing is named, and is nothing known."""
        return any(one.named for one in self.parsed.targets)


class CommandReader:
    def __init__(self, *, settings: Settings, inference: Inference, memory: Memory) -> None:
        self._settings = settings
        self._inference = inference
        self._memory = memory

    async def tasks(self, reading: Reading, last: LastTarget) -> Sequence[CheckedTask | PlainMotion]:
        """One for each thing the command asks for, or the way to the room it names. 'It' in a room is what was asked
        for `last`.

        Raises `UnprocessableError` where no known thing and no known room is asked for, a thing in a room that is not
        known, or something that the robot cannot begin: to pour without an arm. `UnavailableError` where memory, which
        knows the rooms, is away.
        """
        asked = reading.asked
        claims = await self._claims(asked)
        if _may_go_to_a_room(asked, claims):
            known = await self.rooms(needed=speaks_of_a_place(asked))
            room = named_in(asked, known.names)
            if room is not None and known.rooms:
                return (replace(way_to(one_room_meant(room, known)), map_id=known.map_id),)
        return await self._things_asked(asked, claims, last)

    async def things(self, reading: Reading, last: LastTarget) -> Sequence[CheckedTask]:
        """One for each thing asked for, in the order said; what concerns all of it is told of the first. Raises as
        `tasks` does.
        """
        return await self._things_asked(reading.asked, await self._claims(reading.asked), last)

    async def _things_asked(self, asked: str, claims: _Claims, last: LastTarget) -> Sequence[CheckedTask]:
        restrictions = restrictions_in(asked)
        self._refuse_pouring(asked, claims)
        claims, restrictions = await self._within(asked, claims, restrictions, last)
        if not claims.found:
            raise await self._not_understood(asked, restrictions, claims)
        left_out = f"left out, not known: {', '.join(claims.unknown)}" if claims.unknown else ""
        first, *others = claims.found
        told = [first.notes, claims.note, claims.parsed.notes, not_held_to(restrictions), left_out]
        told += [what_it_cannot(first.action)]
        return [replace(first, notes="; ".join(filter(None, told))), *others]

    async def _within(
        self, asked: str, claims: _Claims, restrictions: Sequence[Restriction], last: LastTarget
    ) -> tuple[_Claims, Sequence[Restriction]]:
        """The same with the rooms that each thing is to be looked for in, and without what only says these."""
        known = await self._rooms(asked)
        said = rooms_said(asked, claims.said or (asked,), known.names)
        if not any(said):
            return claims, restrictions
        found = claims.found
        if not found and not claims.unknown_named and means_the_last(asked):
            found = (_again(asked, await last()),)
        try:
            rooms = [rooms_meant(one, known) if one is not None else () for one in said]
        except UnknownRoomError as error:
            if not found:
                return claims, restrictions
            raise UnprocessableError(str(error)[:400], code=CommandRefusal.UNKNOWN_ROOM.value) from None
        within = tuple(replace(task, rooms=some) for task, some in zip(found, rooms, strict=False))
        return replace(claims, found=within), not_of_a_room(restrictions, said)

    async def _rooms(self, asked: str) -> KnownRooms:
        """Those of the home, where a room may be said. Raises `UnavailableError` where one is said, and memory, which
        knows where it is, is away."""
        try:
            return await self.rooms(needed=may_say_where(asked))
        except UnavailableError:
            said = searched_in(asked)
            if said is None:
                return KnownRooms()
            text = f"only it knows where the {said.name} is, and it tells no rooms now"
            raise UnavailableError("memory", text) from None

    async def understand(self, readings: Sequence[str]) -> Understood:
        """What several readings of one saying mean together; the first is the likeliest, the last the plainest."""
        some = [one for one in readings if words_of(one)]
        if not some:
            return Understood(question=NOT_UNDERSTOOD)
        if len(some) == 1:
            return Understood(intent=await self.intent(some[0]))
        orders = [one for one in map(_order, some) if one is not None and one.action in GRAVEST]
        if orders:  # before anything is put right: what would be dropped as a repeat may be the stop
            return understood([HeardIntent(one, sure=True) for one in orders])
        words = len(words_of(some[-1]))
        heard = dict.fromkeys(by_ear(said_once(one, words)) for one in some)
        return understood([await self._heard(one) for one in heard])

    async def _heard(self, one: HeardText) -> HeardIntent:
        intent = await self.intent(one.text)
        said = intent.action is not WantedAction.FIND or read(one.text).sure
        return HeardIntent(intent, one.sure and said and uses_all_colours(intent))

    async def intent(self, text: str) -> Intent:
        """What the words mean, as data; nothing is begun. An order in them ('stop') is the intent, unless more is
        asked for behind it.
        """
        if (ordered := _order(text)) is not None:
            return ordered
        order = order_in(text)
        asked = text if order is None else order.rest
        reading = read(asked)
        if is_docking(asked):
            return Intent(action=WantedAction.DOCK, command=text, mood=Mood.FIND)
        if is_foreign(asked):
            return Intent(action=WantedAction.NOTHING, command=text, mood=Mood.UNKNOWN)
        if reading.mood in QUESTIONS:
            return _question(text, QUESTIONS[reading.mood], reading.mood)
        if reading.mood is not Mood.FIND:
            return Intent(action=WantedAction.NOTHING, command=text, mood=reading.mood)
        return await self._wish(text, reading.asked, await self._claims(reading.asked))

    async def _wish(self, text: str, asked: str, claims: _Claims) -> Intent:
        action = claims.found[0].action if claims.found else action_in(asked)
        to_room = _may_go_to_a_room(asked, claims)
        rooms = await self._rooms_for_words(needed=to_room or may_say_where(asked))
        goal = named_in(asked, rooms.names) if to_room else None
        said = rooms_said(asked, claims.said or (asked,), rooms.names)
        within = next((one.name for one in said if one is not None), None)
        unknown = goal if goal is not None and not rooms.meant(goal) else None
        known = claims.found or goal is not None or claims.parsed.mood is Mood.FIND
        return Intent(
            action=action if known else WantedAction.NOTHING,
            command=text,
            targets=tuple(one.target for one in claims.found)[:8],
            unknown=claims.unknown[:8],
            room=goal or within,
            mood=Mood.FIND if known else Mood.UNKNOWN,
            able=what_it_cannot(action, unknown_room=unknown),
        )

    async def rooms(self, *, needed: bool = True) -> KnownRooms:
        """None where none are needed, or the home has none. Raises `UnavailableError` where memory is away."""
        if not needed:
            return KnownRooms()
        try:
            async with asyncio.timeout(self._settings.recall_timeout_s):
                told = await self._memory.rooms()
                return KnownRooms(told.rooms, told.map_id or None)
        except UpstreamError as error:
            if error.upstream_status == HTTPStatus.NOT_FOUND:  # it names no rooms
                return KnownRooms()
            away = error.detail
        except (MeshError, TimeoutError) as error:
            away = str(error)
        log.warning("memory tells no rooms", reason=away)
        raise UnavailableError("memory", "only it knows where the rooms are, and it tells none now")

    async def _rooms_for_words(self, *, needed: bool) -> KnownRooms:
        """The same where nothing is begun yet: a kind of room is heard without memory."""
        try:
            return await self.rooms(needed=needed)
        except UnavailableError:
            return KnownRooms()

    async def _claims(self, asked: str) -> _Claims:
        labels, note = await self._labels()
        parsed = await self._inference.parse_task(ParseTaskRequest(command=asked, labels_in_memory=labels))
        checked = [(one, check_parse(one, labels) if one.said in asked else None) for one in parsed.targets]
        found = tuple(task for _, task in checked if task is not None)
        said = tuple(one.said for one, task in checked if task is not None)
        unknown = tuple(one.said for one, task in checked if task is None)
        return _Claims(found, said, unknown, parsed, note)

    def _refuse_pouring(self, asked: str, claims: _Claims) -> None:
        """A person is asked: to find the bottle is no part of what he said, as it is of 'bring'."""
        actions = {one.action for one in claims.found} or {action_in(asked)}
        if WantedAction.POUR not in actions:
            return
        known = [f"say 'find the {one.target.description}'" for one in claims.found]
        text = f"{what_it_cannot(WantedAction.POUR)}: {' or '.join(known) or 'it is nothing I know by sight'}"
        raise UnprocessableError(text[:400], code=CommandRefusal.NO_ARM.value)

    async def _not_understood(
        self, asked: str, restrictions: Sequence[Restriction], claims: _Claims
    ) -> UnprocessableError:
        """The refusal: a question back where only a room, or the colour of a thing, was said."""
        colour = next((one.value for one in restrictions if one.kind is RestrictionKind.ANY), "")
        room = room_in(without_neighbours(asked, ())) if action_in(asked) is WantedAction.GO else None
        if room is not None:
            marks = [one.label for one in await self._things() if one.label in ROOMS[room]]
            hint = " or ".join(f"'go to the {one}'" for one in dict.fromkeys(marks)) or f"'go to the {ROOMS[room][0]}'"
            text = f"{what_it_cannot(WantedAction.GO, unknown_room=room)}. Say {hint}"
            return UnprocessableError(text, code=CommandRefusal.NO_ROOMS.value)
        if not colour:
            notes = "; ".join(filter(None, (*(one.notes for one in claims.parsed.targets), claims.parsed.notes)))
            text = f"'{asked[:100]}' names nothing I know: {notes or 'no such class'}"
            return UnprocessableError(text, code=CommandRefusal.NAMES_NOTHING.value)
        named = dict.fromkeys(f"{colour} {one.label}" for one in await self._things() if one.colour == colour)
        known = list(named)[:6]
        hint = f"I remember: {', '.join(known)}" if known else f"say what it is, for example: the {colour} bottle"
        return UnprocessableError(f"Which {colour} thing? {hint}", code=CommandRefusal.WHICH_THING.value)

    async def _things(self) -> Sequence[RememberedObject]:
        try:
            async with asyncio.timeout(self._settings.recall_timeout_s):
                return await self._memory.objects(None, OBJECTS_ASKED)
        except (MeshError, TimeoutError):
            return ()

    async def _labels(self) -> tuple[tuple[str, ...], str]:
        try:
            async with asyncio.timeout(self._settings.recall_timeout_s):
                found = await self._memory.labels()
        except (MeshError, TimeoutError) as error:
            log.warning("memory is away", error=str(error))
            return (), "memory is away"
        return tuple(count.label for count in found)[:500], ""


def _may_go_to_a_room(asked: str, claims: _Claims) -> bool:
    """Of 'go to my keys in the kitchen' the keys are the goal, known or not."""
    return not claims.found and not claims.unknown_named and action_in(asked) is WantedAction.GO


def _again(asked: str, target: Target | None) -> CheckedTask:
    """The same thing once more. Raises `UnprocessableError` where nothing was asked for before."""
    if target is None:
        raise UnprocessableError(
            "Which thing? Nothing was asked for before: say what to look for", code=CommandRefusal.WHICH_THING.value
        )
    return CheckedTask(target, None, "rules", f"'it' is the {target.description}", action_in(asked))


def not_held_to(restrictions: Sequence[Restriction]) -> str:
    """What was said of the thing and is no condition of the search, for a person; '' where there is nothing."""
    loose = [one.said for one in restrictions if one.kind not in {RestrictionKind.NOT_COLOUR, RestrictionKind.ANY}]
    return f"understood, but not held to: {', '.join(loose)}" if loose else ""


def _order(text: str) -> Intent | None:
    """The order in the words; None where there is none, or more is asked for behind it."""
    order = order_in(text)
    if order is None:
        return None
    behind = read(order.rest)
    asks_more = behind.mood is Mood.FIND and behind.sure
    return None if asks_more else Intent(action=WantedAction(order.mood.value), command=text, mood=order.mood)


def _question(text: str, action: WantedAction, mood: Mood) -> Intent:
    asked = parse_question(text)
    thing = " ".join(filter(None, (asked.colour, asked.label)))
    targets = (Target(label=asked.label, description=thing),) if asked.label is not None else ()
    return Intent(action=action, command=text, targets=targets, room=asked.room, about=asked.about, mood=mood)
