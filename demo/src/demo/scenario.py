"""Reads from a command which thing the generated home must hold, where it is one of the simulator's kinds."""

import re

from contracts.colours import Colour
from sim.home import Wanted
from sim.home.catalog import KINDS

ALSO = {"mug": "cup", "teddy": "teddy bear", "ball": "sports ball", "sofa": "couch", "fridge": "refrigerator"}


def wanted_in(command: str) -> Wanted | None:
    """The last kind the command names, in the colour before it where that kind comes in it; none when it names none."""
    words = " ".join(re.findall(r"[a-z]+", command.lower()))
    names = {kind: kind for kind in KINDS} | ALSO
    found = [(match.end(), len(name), name) for name in names for match in re.finditer(rf"\b{name}s?\b", words)]
    if not found:
        return None
    end, length, name = max(found)
    before = words[: end - length]
    colour = next((c for c in Colour if c in KINDS[names[name]].colours and re.search(rf"\b{c}\b", before)), None)
    return Wanted(kind=names[name], colour=colour)
