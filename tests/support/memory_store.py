"""A store in dicts, with the behaviour of `memory.adapters.store.SqlStore`; one suite runs over both."""

import math
from collections import Counter, defaultdict
from collections.abc import AsyncGenerator, AsyncIterable, Callable, Collection, Mapping, Sequence
from contextlib import AbstractAsyncContextManager
from dataclasses import replace
from itertools import count
from typing import TypeVar

from contracts.memory import Area, ForgetRequest, LabelCount, Observation
from memory.belief import LOST_BELOW, after_miss
from memory.frames import Frame, Tally
from memory.object_association import Ledger
from memory.objects import MapObject
from memory.ports import Candidates, Counts, ExportBatch, KeptMap, KeptRoom, StoredView, in_maps
from memory.views import AggregatedView, ViewCell, contradicted, merged, view_at
from mesh.errors import UnavailableError, UnprocessableError
from store.copies import DatabaseCopy, JudgedDatabase

K = TypeVar("K")
V = TypeVar("V")


class FakeStore:
    """`away` makes every call fail as a locked file does; `writes` holds the observations of each write."""

    def __init__(self, *, views_max: int = 1_000_000, things_max: int = 5_000) -> None:
        self.away = ""
        self.closed = False
        self.writes: list[tuple[Observation, ...]] = []
        self.frames: list[Frame] = []
        self._views_max = views_max
        self._things_max = things_max
        self._maps: dict[int, tuple[str, float]] = {0: ("", 0.0)}
        self._rooms: list[KeptRoom] = []
        self._things: dict[int, MapObject] = {}
        self._views: dict[ViewCell, tuple[int, AggregatedView, float]] = {}
        self._thing_ids = count(1)
        self._view_ids = count(1)

    async def remember(self, frames: Sequence[Frame]) -> Tally:
        self._there()
        self.writes.append(tuple(one for frame in frames for one in frame.seen))
        self.frames += frames
        ledger = Ledger.of(self._things.values())
        tallies = [ledger.apply(frame) for frame in frames]
        numbers = self._keep([ledger.things[number] for number in sorted(ledger.changed, key=abs)])
        for sighting in ledger.sightings.values():
            self._sight(sighting, numbers, lambda old, new: old + new)
        for frame in frames:
            if frame.is_look:
                self._disbelieve(frame)
        self._things = dict(_newest(self._things, self._things_max, lambda thing: thing.last_seen_s))
        self._drop_orphans()
        self._views = dict(_newest(self._views, self._views_max, lambda kept: kept[1].last_seen_s))
        return Tally(sum(one.confirmed for one in tallies), sum(one.missed for one in tallies))

    async def maps(self) -> tuple[KeptMap, ...]:
        self._there()
        kept = [KeptMap(number, name, seen_s) for number, (name, seen_s) in self._maps.items()]
        return tuple(sorted(kept, key=lambda one: (-one.last_seen_s, -one.number)))

    async def map_sizes(self) -> dict[int, tuple[int, int]]:
        self._there()
        views = Counter(place.map_number for place in self._views)
        things = Counter(one.map_number for one in self._things.values())
        return {number: (views[number], things[number]) for number in {*views, *things}}

    async def enter_map(self, map_id: str, was: Collection[str], now_s: float) -> int:
        self._there()
        if [name for name, _ in self._maps.values()] == [""]:
            self._maps = {number: (map_id, now_s) for number in self._maps}
        number = self._numbered(map_id, now_s)
        for old in [old for old, (name, _) in self._maps.items() if name in was and old != number]:
            self._merge(old, number)
        self._maps[number] = (map_id, now_s)
        return number

    async def maps_with(self, label: str, limit: int) -> tuple[int, ...]:
        self._there()
        return tuple({place.map_number for place in self._views if place.label == label})[:limit]

    async def rooms(self, map_number: int) -> tuple[KeptRoom, ...]:
        self._there()
        return tuple(one for one in self._rooms if one.map_number == map_number)

    async def add_rooms(self, map_number: int, places: Sequence[tuple[float, float]]) -> bool:
        self._there()
        if map_number not in self._maps:
            return False
        for x, y in places:
            self._rooms.append(KeptRoom(len(self._rooms) + 1, map_number, self._most(map_number) + 1, x, y))
        return True

    async def name_room(self, map_number: int, room_id: int, name: str, shown: Collection[int]) -> int | None:
        if map_number not in self._maps:
            return None
        of_map = [one for one in await self.rooms(map_number) if name and one.id != room_id]
        others = {one.id for one in of_map if one.name.casefold() == name.casefold()}
        if holders := sorted(others & {*shown}):
            return holders[0]
        given = {**dict.fromkeys(others, ""), room_id: name}
        self._rooms = [replace(one, name=given.get(one.id, one.name)) for one in self._rooms]
        return room_id

    def _most(self, map_number: int) -> int:
        return max((one.number for one in self._rooms if one.map_number == map_number), default=0)

    async def views(self, label: str | None, limit: int, map_number: int | None = None) -> list[StoredView]:
        self._there()
        return self._best(lambda place: label in {None, place.label} and map_number in {None, place.map_number})[:limit]

    async def things(
        self, label: str | None, area: Area | None, limit: int, map_number: int | None = None
    ) -> list[MapObject]:
        self._there()
        wanted = [
            one
            for one in self._things.values()
            if label in {None, one.label} and _inside(one.x, one.y, area) and map_number in {None, one.map_number}
        ]
        return sorted(wanted, key=lambda one: (-one.last_seen_s, one.id))[:limit]

    async def thing(self, number: int) -> MapObject | None:
        self._there()
        return self._things.get(number)

    async def labels(self, limit: int, map_number: int | None = None) -> list[LabelCount]:
        self._there()
        by_label: dict[str, list[AggregatedView]] = defaultdict(list)
        for place, (_, kept, _) in self._views.items():
            if map_number in {None, place.map_number}:
                by_label[place.label].append(kept)
        counts = [
            LabelCount(
                label=label,
                views=len(all_of),
                best_confidence=max(one.confidence for one in all_of),
                last_seen_s=max(one.last_seen_s for one in all_of),
                objects=sum(
                    1 for one in self._things.values() if one.label == label and map_number in {None, one.map_number}
                ),
            )
            for label, all_of in by_label.items()
        ]
        return sorted(counts, key=lambda one: (-one.views, one.label.encode()))[:limit]

    async def candidates(
        self, wanted: Mapping[str, Collection[str]], *, map_number: int = 0, views_a_thing: int, views_max: int
    ) -> dict[str, Candidates]:
        """All things there are, so that no colour can be left out."""
        self._there()
        found: dict[str, Candidates] = {}
        for label, colours in wanted.items():
            of = (map_number, label)
            things = {one.id: one for one in self._things.values() if (one.map_number, one.label) == of}
            loose = self._best(lambda place, of=of: (place.map_number, place.label) == of and place.thing_id is None)
            coloured = [one for one in loose[views_max:] if one.colour in colours]
            views = [*loose[:views_max], *coloured[:views_max]]
            for number in things:
                views += self._best(lambda place, number=number: place.thing_id == number)[:views_a_thing]
            found[label] = Candidates(things, tuple(sorted(views, key=lambda one: one.id)))
        return found

    async def forget(self, what: ForgetRequest, map_number: int | None = None) -> int:
        self._there()
        gone = [
            one.id
            for one in self._things.values()
            if _met(one.label, one.x, one.y, one.last_seen_s, what) and map_number in {None, one.map_number}
        ]
        number = sum([await self.forget_thing(one) for one in gone])
        places = [
            place
            for place, (_, kept, _) in self._views.items()
            if _met(place.label, kept.pose.x, kept.pose.y, kept.last_seen_s, what)
            and map_number in {None, place.map_number}
        ]
        for place in places:
            del self._views[place]
        return number + len(places)

    async def forget_thing(self, number: int) -> int:
        self._there()
        before = len(self._views) + len(self._things)
        self._things.pop(number, None)
        self._drop_orphans()
        return before - len(self._views) - len(self._things)

    async def tidy(self, *, lost_before_s: float, seen_before_s: float) -> int:
        self._there()
        gone = [
            one.id
            for one in self._things.values()
            if one.last_seen_s < seen_before_s
            or (one.belief < LOST_BELOW and (one.last_seen_s < lost_before_s or _ghost(one)))
        ]
        number = sum([await self.forget_thing(one) for one in gone])
        old = [place for place, (_, kept, _) in self._views.items() if kept.last_seen_s < seen_before_s]
        for place in old:
            del self._views[place]
        return number + len(old)

    async def counts(self) -> Counts:
        self._there()
        kept = [sighting for _, sighting, _ in self._views.values()]
        stamps = [one.last_seen_s for one in kept]
        return Counts(
            labels=len({one.place.label for one in kept}),
            views=len(kept),
            sightings=sum(one.count for one in kept),
            things=tuple(self._things.values()),
            oldest_s=min(stamps, default=None),
            newest_s=max(stamps, default=None),
            database="dict",
            size_bytes=None,
        )

    async def export_batches(self) -> AsyncGenerator[ExportBatch]:
        self._there()
        yield ExportBatch(maps=await self.maps())
        yield ExportBatch(things=tuple(sorted(self._things.values(), key=lambda one: one.id)))
        yield ExportBatch(views=tuple(sorted(self._best(lambda place: True), key=lambda one: one.id)))

    async def import_batch(self, hoard: ExportBatch) -> None:
        self._there()
        hoard = in_maps(hoard, {one.number: self._numbered(one.id, one.last_seen_s) for one in hoard.maps})
        there = {_fingerprint(one): one.id for one in self._things.values()}
        numbers = {one.id: there[_fingerprint(one)] for one in hoard.things if _fingerprint(one) in there}
        new = [one for one in hoard.things if one.id not in numbers]
        numbers |= {one.id: next(self._thing_ids) for one in new}
        for one in new:
            self._things[numbers[one.id]] = _renumbered(one, numbers)
        for view in hoard.views:
            sighting = view_at(
                view.label,
                "" if view.thing_id is not None else view.colour,
                view.pose,
                confidence=view.confidence,
                last_seen_s=view.last_seen_s,
                count=view.count,
                thing_id=view.thing_id,
                map_number=view.map_number,
            )
            self._sight(sighting, numbers, max)

    async def snapshot(self) -> DatabaseCopy:
        raise UnprocessableError("a dict has no back-up")

    def candidate(self, body: AsyncIterable[bytes], *, bytes_max: int) -> AbstractAsyncContextManager[JudgedDatabase]:
        raise UnprocessableError("a dict has no back-up")

    async def replace(self, candidate: JudgedDatabase) -> str:
        raise UnprocessableError("a dict has no back-up")

    async def check(self) -> None:
        self._there()

    async def aclose(self) -> None:
        self.closed = True

    def _numbered(self, map_id: str, seen_s: float) -> int:
        for number, (name, _) in self._maps.items():
            if name == map_id:
                return number
        number = max(self._maps) + 1
        self._maps[number] = (map_id, seen_s)
        return number

    def _merge(self, old: int, new: int) -> None:
        del self._maps[old]
        most = self._most(new)
        taken = {one.name.casefold() for one in self._rooms if one.map_number == new}
        self._rooms = [
            replace(
                one, map_number=new, number=one.number + most, name="" if one.name.casefold() in taken else one.name
            )
            if one.map_number == old
            else one
            for one in self._rooms
        ]
        self._things = {
            number: replace(one, map_number=new) if one.map_number == old else one
            for number, one in self._things.items()
        }
        for place in [place for place in self._views if place.map_number == old]:
            view_id, kept, believed_s = self._views.pop(place)
            there = replace(place, map_number=new)
            moved = replace(kept, place=there)
            if there in self._views:
                view_id, before, other_s = self._views[there]
                moved, believed_s = merged(before, moved), max(believed_s, other_s)
            self._views[there] = (view_id, moved, believed_s)

    def _keep(self, changed: list[MapObject]) -> dict[int, int]:
        numbers = {one.id: next(self._thing_ids) for one in changed if one.id < 0}
        for one in changed:
            self._things[numbers.get(one.id, one.id)] = _renumbered(one, numbers)
        return numbers

    def _sight(self, new: AggregatedView, numbers: dict[int, int], counted: Callable[[int, int], int]) -> None:
        number = new.place.thing_id
        place = replace(new.place, thing_id=None if number is None else numbers.get(number, number))
        new = replace(new, place=place)
        if place in self._views:
            view_id, old, believed_s = self._views[place]
            both = replace(merged(old, new), count=counted(old.count, new.count))
            self._views[place] = (view_id, both, max(believed_s, new.last_seen_s))
        else:
            self._views[place] = (next(self._view_ids), new, new.last_seen_s)

    def _disbelieve(self, frame: Frame) -> None:
        for place, (view_id, kept, believed_s) in list(self._views.items()):
            if (place.map_number, place.thing_id) == (frame.map_number, None) and contradicted(
                place.label, kept.pose, believed_s, frame
            ):
                belief, _ = after_miss(kept.belief, 0.6)
                if belief < 0.05:
                    del self._views[place]
                else:
                    self._views[place] = (view_id, replace(kept, belief=belief), frame.stamp_s)

    def _best(self, wanted: Callable[[ViewCell], bool]) -> list[StoredView]:
        found = [self._view(place, *kept) for place, kept in self._views.items() if wanted(place)]
        return sorted(found, key=lambda one: (-one.confidence, one.id))

    def _view(self, place: ViewCell, number: int, kept: AggregatedView, believed_s: float) -> StoredView:
        thing = self._things.get(place.thing_id) if place.thing_id is not None else None
        return StoredView(
            id=number,
            label=place.label,
            colour=(thing.colour or "") if thing is not None else place.colour,
            x=kept.pose.x,
            y=kept.pose.y,
            yaw=kept.pose.yaw,
            confidence=kept.confidence,
            last_seen_s=kept.last_seen_s,
            count=kept.count,
            belief=kept.belief,
            believed_s=believed_s,
            map_number=place.map_number,
            thing_id=place.thing_id,
        )

    def _drop_orphans(self) -> None:
        self._views = {place: kept for place, kept in self._views.items() if place.thing_id in {None, *self._things}}
        for number, one in self._things.items():
            here = {number: number for number in self._things}
            self._things[number] = replace(
                one, moved_from=here.get(one.moved_from or 0), moved_to=here.get(one.moved_to or 0)
            )

    def _there(self) -> None:
        if self.away:
            raise UnavailableError("database", self.away)


def _renumbered(thing: MapObject, numbers: dict[int, int]) -> MapObject:
    def given(number: int | None) -> int | None:
        return None if number is None else numbers.get(number, number)

    return replace(
        thing,
        id=numbers.get(thing.id, thing.id),
        moved_from=given(thing.moved_from),
        moved_to=given(thing.moved_to),
        colours={word: round(votes, 3) for word, votes in thing.colours.items()},
    )


def _newest(kept: dict[K, V], most: int, age: Callable[[V], float]) -> list[tuple[K, V]]:
    """Everything, or where that is too much the 95 % of `most` that were last seen."""
    items = list(kept.items())
    if len(items) <= most:
        return items
    order = sorted(range(len(items)), key=lambda index: (age(items[index][1]), index))
    keep = set(order[len(items) - int(most * 0.95) :])
    return [item for index, item in enumerate(items) if index in keep]


def _met(label: str, x: float, y: float, last_seen_s: float, what: ForgetRequest) -> bool:
    return (
        what.label in {None, label}
        and _inside(x, y, what.area)
        and last_seen_s >= (what.seen_after_s if what.seen_after_s is not None else -math.inf)
        and last_seen_s < (what.seen_before_s if what.seen_before_s is not None else math.inf)
    )


def _inside(x: float, y: float, area: Area | None) -> bool:
    return area is None or (area.x_min <= x <= area.x_max and area.y_min <= y <= area.y_max)


def _ghost(thing: MapObject) -> bool:
    return thing.times_seen <= 2 and thing.moved_to is None


def _fingerprint(thing: MapObject) -> tuple[int, str, float, float, float]:
    return thing.map_number, thing.label, thing.first_seen_s, round(thing.x, 2), round(thing.y, 2)
