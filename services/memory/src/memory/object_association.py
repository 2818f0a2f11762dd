"""Applies frames to what is remembered: which things they show, which are missing, which have moved (pure)."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

from contracts.memory import Observation
from memory.belief import after_miss
from memory.frames import Frame, Miss, Tally
from memory.objects import MapObject, could_be_the_same, first_seen, matches, seen_again, usable_position
from memory.views import AggregatedView, ViewCell, merged, view_of

SAME_PLACE_M = 0.3
NEWLY_SEEN = 5
"""A thing seen no more often than this may be one that was lost elsewhere."""
ANEW_S = 3600.0
"""After so long a look from the same place proves something again."""


Kind = tuple[int, str]
"""A map's number and a label: things of another kind cannot be the same thing."""


@dataclass
class Ledger:
    """Open it with every thing of the labels that the frames speak of; afterwards `changed` and `sightings` are to be
    written. Things with an id below zero are new."""

    things: dict[int, MapObject]
    changed: set[int] = field(default_factory=set[int])
    sightings: dict[ViewCell, AggregatedView] = field(default_factory=dict[ViewCell, AggregatedView])
    _last_number: int = 0
    _of_kind: dict[Kind, set[int]] = field(default_factory=lambda: defaultdict[Kind, set[int]](set))

    @classmethod
    def of(cls, things: Iterable[MapObject]) -> "Ledger":
        opened = cls({thing.id: thing for thing in things})
        opened._last_number = max(opened.things, default=0)
        for thing in opened.things.values():
            opened._of_kind[_kind(thing)].add(thing.id)
        return opened

    def apply(self, frame: Frame) -> Tally:
        """Sightings first: what a frame shows is not missing from it."""
        shown = self._take_in(frame.seen, frame.map_number)
        missed = 0
        for miss in frame.misses:
            if miss.thing_id not in shown and self._miss(miss, frame):
                missed += 1
        return Tally(confirmed=len(shown), missed=missed)

    def _take_in(self, seen: Sequence[Observation], map_number: int) -> set[int]:
        by_label: dict[str, list[Observation]] = defaultdict(list)
        for one in seen:
            if usable_position(one) is None:
                self._sight(view_of(one, None, map_number))
            else:
                by_label[one.label].append(one)
        return {
            thing_id
            for label, observations in by_label.items()
            for thing_id in self._identify((map_number, label), observations)
        }

    def _identify(self, kind: Kind, observations: Sequence[Observation]) -> Iterable[int]:
        known = [self.things[number] for number in self._of_kind[kind]]
        for one, match in zip(observations, matches(observations, known), strict=True):
            position = one.position
            assert position is not None
            if match is None:
                thing = replace(first_seen(one, position, self._new_number()), map_number=kind[0])
                self._of_kind[kind].add(thing.id)
            else:
                self._disown(match)
                thing = seen_again(match, one, position)
            self._put(thing)
            if thing.moved_from is None and thing.times_seen <= NEWLY_SEEN:
                self._came_from(thing)
            self._sight(view_of(one, thing.id, kind[0]))
            yield thing.id

    def _miss(self, miss: Miss, frame: Frame) -> bool:
        """False where it is gone by now, or was seen since."""
        thing = self.things.get(miss.thing_id)
        if thing is None or thing.label != miss.label or thing.last_seen_s > frame.stamp_s:
            return False
        x, y = frame.pose.x, frame.pose.y
        last_s = thing.last_missed_s
        same_place = (
            last_s is not None
            and frame.stamp_s - last_s < ANEW_S
            and abs(thing.miss_x - x) < SAME_PLACE_M
            and abs(thing.miss_y - y) < SAME_PLACE_M
        )
        belief, loss = after_miss(
            thing.belief_at(frame.stamp_s), miss.detectability, thing.miss_loss if same_place else 1.0
        )
        was_lost = thing.lost
        thing = replace(
            thing,
            belief=belief,
            believed_s=max(thing.believed_s, frame.stamp_s),
            times_missed=thing.times_missed + 1,
            last_missed_s=max(frame.stamp_s, last_s or 0.0),
            miss_x=thing.miss_x if same_place else x,
            miss_y=thing.miss_y if same_place else y,
            miss_loss=loss,
        )
        self._put(thing)
        if thing.lost and not was_lost:
            self._went_to(thing)
        return True

    def _came_from(self, thing: MapObject) -> None:
        """Of the lost things it could be, the one last seen is where it was before."""
        before = [
            one
            for one in self._alike(thing, lost=True)
            if one.moved_to is None and one.last_seen_s <= thing.first_seen_s
        ]
        if before:
            self._link(max(before, key=_lately), thing)

    def _went_to(self, thing: MapObject) -> None:
        """Of the things that have turned up since it was last seen, the newest is where it is now."""
        since = [
            one
            for one in self._alike(thing, lost=False)
            if one.moved_from is None and one.first_seen_s >= thing.last_seen_s
        ]
        if since:
            self._link(thing, max(since, key=_lately))

    def _alike(self, thing: MapObject, *, lost: bool) -> list[MapObject]:
        """Of its map, label and look, lost or not as asked."""
        same = [self.things[number] for number in self._of_kind[_kind(thing)] if number != thing.id]
        return [one for one in same if one.lost is lost and could_be_the_same(one, thing)]

    def _link(self, before: MapObject, after: MapObject) -> None:
        self._put(replace(before, moved_to=after.id))
        self._put(replace(after, moved_from=before.id))

    def _disown(self, thing: MapObject) -> None:
        """It is seen where it was: what was taken for its new self is another thing."""
        after = self.things.get(thing.moved_to) if thing.moved_to is not None else None
        if after is not None:
            self._put(replace(after, moved_from=None))

    def _new_number(self) -> int:
        """Below zero, and farther from it than any other: the order in which things came can be told by it."""
        self._last_number += 1
        return -self._last_number

    def _put(self, thing: MapObject) -> None:
        self.things[thing.id] = thing
        self.changed.add(thing.id)

    def _sight(self, new: AggregatedView) -> None:
        old = self.sightings.get(new.place)
        self.sightings[new.place] = new if old is None else merged(old, new)


def _kind(thing: MapObject) -> Kind:
    return thing.map_number, thing.label


def _lately(thing: MapObject) -> tuple[float, int]:
    return thing.last_seen_s, abs(thing.id)
