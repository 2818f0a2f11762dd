"""A home as pure, immutable data: generated from a seed, saved to and loaded from a versioned JSON file."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from pydantic import ConfigDict, TypeAdapter, ValidationError

from sim.home.appearance import decorate
from sim.home.catalog import ALL_COLOURS, FURNITURE, THINGS
from sim.home.floor import Floor
from sim.home.furnish import furnish
from sim.home.layout import plan
from sim.home.model import Appearance, Dock, Door, Furniture, Room, Thing, Wall, Wanted
from sim.home.placement import place_things

FILE_VERSION: Final = 1
_ATTEMPTS = 30
_FEWEST_PIECES = 32
_CONFIG = ConfigDict(extra="forbid")


class HomeFileError(ValueError):
    """A home file that cannot be read: not JSON, another version, or not the shape of a home."""


@dataclass(frozen=True)
class Home:
    """One furnished home; x and y start at the outer corner of the plan (0, 0), z at the floor, all in m and rad."""

    __pydantic_config__ = _CONFIG
    seed: int
    rooms: tuple[Room, ...]
    walls: tuple[Wall, ...]
    doors: tuple[Door, ...]
    furniture: tuple[Furniture, ...]
    things: tuple[Thing, ...]
    dock: Dock
    appearance: Appearance

    @classmethod
    def generate(cls, seed: int, *, wanted: Wanted | None = None) -> "Home":
        """The home of a seed; the same arguments always give the same home.

        `wanted` guarantees exactly one thing of that kind and colour (any one colour if None) and, where the kind
        comes in colours, at least one of another colour to tell it from. ValueError for a kind or a colour that
        no home can hold.
        """
        if seed < 0:
            raise ValueError(f"a seed is 0 or more, not {seed}")
        must = _wishes(seed, wanted)
        for attempt in range(_ATTEMPTS):
            home = _attempt(seed, attempt, must)
            if home is not None:
                return home
        raise RuntimeError(f"no home for seed {seed} holds {wanted} after {_ATTEMPTS} attempts")

    @property
    def width_m(self) -> float:
        """Extent along x between the middles of the outer walls."""
        return max(room.x_max_m for room in self.rooms) + min(room.x_min_m for room in self.rooms)

    @property
    def depth_m(self) -> float:
        """Extent along y between the middles of the outer walls."""
        return max(room.y_max_m for room in self.rooms) + min(room.y_min_m for room in self.rooms)

    def save(self, path: Path | str) -> None:
        """Write the home as JSON."""
        body = {"version": FILE_VERSION, "home": _ADAPTER.dump_python(self, mode="json")}
        Path(path).write_text(json.dumps(body, indent=1) + "\n", encoding="utf-8")

    @classmethod
    def load(cls, path: Path | str) -> "Home":
        """Read a home that `save` wrote; HomeFileError says what is wrong with any other file."""
        text = Path(path).read_text(encoding="utf-8")
        try:
            body = json.loads(text)
        except json.JSONDecodeError as error:
            raise HomeFileError(f"{path} is not JSON: {error}") from error
        match body:
            case {"version": version, "home": home} if version == FILE_VERSION:
                pass
            case _:
                raise HomeFileError(f"{path} is not a home file of version {FILE_VERSION}")
        try:
            return _ADAPTER.validate_json(json.dumps(home), strict=True)
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            where = ".".join(str(part) for part in first["loc"])
            raise HomeFileError(f"{path}: {where or 'home'}: {first['msg']}") from error


_ADAPTER: Final = TypeAdapter(Home)


def _wishes(seed: int, wanted: Wanted | None) -> tuple[tuple[str, str | None], ...]:
    """(kind, colour) of the wanted thing and its distractor."""
    if wanted is None:
        return ()
    entry = THINGS.get(wanted.kind) or FURNITURE.get(wanted.kind)
    if entry is None:
        raise ValueError(f"no home holds a {wanted.kind!r}")
    if wanted.colour is not None and wanted.colour not in entry.colours:
        known = ", ".join(sorted(set(entry.colours))) or "its natural colour only"
        raise ValueError(f"no home holds a {wanted.colour!r} {wanted.kind}; it comes in: {known}")
    if not entry.colours:
        return ((wanted.kind, None),)
    rng = np.random.default_rng([seed, 7])
    colour = wanted.colour or str(rng.choice(entry.colours))
    others = [c for c in ALL_COLOURS if c in entry.colours and c != colour]
    return ((wanted.kind, colour), (wanted.kind, str(rng.choice(others))))


def _attempt(seed: int, attempt: int, must: tuple[tuple[str, str | None], ...]) -> Home | None:
    """One try with its own random numbers; None when the rooms came out too empty or a wish found no place."""
    layout = plan(np.random.default_rng([seed, attempt, 1]))
    rng = np.random.default_rng([seed, attempt, 2])
    floor = Floor(layout)
    if floor.standing() is None:
        return None
    furnishing = furnish(layout, rng, floor, tuple(wish for wish in must if wish[0] in FURNITURE))
    things = place_things(
        furnishing, np.random.default_rng([seed, attempt, 3]), tuple(wish for wish in must if wish[0] in THINGS)
    )
    pieces = furnishing.pieces
    held = [(item.kind, item.colour) for item in (*things, *pieces)]
    if len(held) < _FEWEST_PIECES or any(wish not in held for wish in must):
        return None
    looks = decorate(layout, pieces, np.random.default_rng([seed, attempt, 4]))
    return Home(seed, layout.rooms, layout.walls, layout.doors, tuple(pieces), tuple(things), layout.dock, looks)
