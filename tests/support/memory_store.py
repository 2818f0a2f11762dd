"""A store of views in a dict, with the behaviour of `memory.adapters.sqlite.SqliteStore`; one suite runs over both."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from itertools import count

from contracts.memory import LabelCount, Observation, View
from memory.views import Place, Sighting, merge, merged
from mesh.errors import UnavailableError


class FakeStore:
    """`away` makes every call fail as a locked file does; `writes` holds each batch that was written."""

    def __init__(self, *, views_max: int = 1_000_000) -> None:
        self.away = ""
        self.closed = False
        self.writes: list[tuple[Observation, ...]] = []
        self._views_max = views_max
        self._kept: dict[Place, tuple[int, Sighting]] = {}
        self._ids: Iterator[int] = count(1)

    async def add(self, observations: Sequence[Observation]) -> None:
        self._there()
        self.writes.append(tuple(observations))
        for place, new in merge(observations).items():
            if place in self._kept:
                number, old = self._kept[place]
                self._kept[place] = (number, merged(old, new))
            else:
                self._kept[place] = (next(self._ids), new)
        if len(self._kept) > self._views_max:
            newest_first = sorted(self._kept.items(), key=lambda item: (-item[1][1].last_seen_s, -item[1][0]))
            self._kept = dict(newest_first[: int(self._views_max * 0.95)])

    async def views(self, label: str | None, limit: int) -> list[View]:
        self._there()
        wanted = [_view(number, kept) for number, kept in self._kept.values() if label in {None, kept.place.label}]
        return sorted(wanted, key=lambda view: (-view.confidence, view.id))[:limit]

    async def labels(self, limit: int) -> list[LabelCount]:
        self._there()
        by_label: dict[str, list[Sighting]] = defaultdict(list)
        for _, kept in self._kept.values():
            by_label[kept.place.label].append(kept)
        counts = [
            LabelCount(
                label=label,
                views=len(all_of),
                best_confidence=max(one.confidence for one in all_of),
                last_seen_s=max(one.last_seen_s for one in all_of),
            )
            for label, all_of in by_label.items()
        ]
        return sorted(counts, key=lambda one: (-one.views, one.label.encode()))[:limit]

    async def forget(self, label: str) -> int:
        self._there()
        gone = [place for place in self._kept if place.label == label]
        for place in gone:
            del self._kept[place]
        return len(gone)

    async def check(self) -> None:
        self._there()

    async def aclose(self) -> None:
        self.closed = True

    def _there(self) -> None:
        if self.away:
            raise UnavailableError("database", self.away)


def _view(number: int, kept: Sighting) -> View:
    return View(
        id=number,
        label=kept.place.label,
        confidence=kept.confidence,
        pose=kept.pose,
        stamp_s=kept.last_seen_s,
        colour=kept.place.colour or None,
    )
