"""What the model is told of the home and of what was done so far, in about 200 tokens (requirement C10)."""

import math
import re
from typing import Final

from contracts.exploration import ExplorationMemory
from contracts.geometry import Pose2D
from coordinator.exploration.frontiers import Frontier
from coordinator.exploration.surroundings import WAYS, PlaceKind, Surroundings
from geometry.poses import wrap

TOKENS_MAX: Final = 200
TOLD_FRONTIERS: Final = 4
_PIECE = re.compile(r"[A-Za-z]+|[^\sA-Za-z]")
_LETTERS_A_TOKEN: Final = 3
_NOT_PLAIN = re.compile(r"[^a-z0-9 ]+")
_NAME_MAX: Final = 20


def tokens_about(text: str) -> int:
    """No fewer than a byte-pair tokenizer makes of it: a digit or a mark is one, three letters are one."""
    return sum(math.ceil(len(one) / _LETTERS_A_TOKEN) for one in _PIECE.findall(text))


def plain(name: str) -> str:
    """A name that came from a picture or a person, as data: a few lower-case words without marks.

    What stands on a poster is not said on to the model as a sentence. That the robot does nothing it should not rests
    on the check of each decision, not on this.
    """
    return _NOT_PLAIN.sub(" ", name.lower()).strip()[:_NAME_MAX].strip()


def described(
    memory: ExplorationMemory,
    pose: Pose2D | None,
    surroundings: Surroundings | None,
    frontiers: tuple[Frontier, ...],
    half_width_m: float,
) -> str:
    """Lines in the order of their weight; what no longer fits in `TOKENS_MAX` is left out from the end."""
    lines = [
        _here(pose, surroundings, half_width_m),
        _frontiers(pose, frontiers),
        _actions(memory),
        _rooms(memory),
        _found(memory),
        _dead_ends(memory),
    ]
    told: list[str] = []
    for line in filter(None, lines):
        if tokens_about("\n".join([*told, line])) > TOKENS_MAX:
            break
        told.append(line)
    return "\n".join(told)


def _here(pose: Pose2D | None, surroundings: Surroundings | None, half_width_m: float) -> str:
    place = "at unknown" if pose is None else f"at x {pose.x:.1f} y {pose.y:.1f}"
    if surroundings is None:
        return f"{place}; laser silent"
    ways_m = surroundings.ways_m(half_width_m)
    names = ("ahead", "left", "back", "right")
    clear = ", ".join(f"{name} {min(9.9, ways_m[k * WAYS // 4]):.1f}" for k, name in enumerate(names))
    kind = surroundings.place_kind(half_width_m)
    where = "" if kind is PlaceKind.ROOM else f"; {kind.value.replace('_', ' ')}"
    return f"{place}{where}; clear m: {clear}"


def _frontiers(pose: Pose2D | None, frontiers: tuple[Frontier, ...]) -> str:
    if not frontiers or pose is None:
        return ""
    told = (
        f"{one.number} bearing {wrap(math.atan2(one.pose.y - pose.y, one.pose.x - pose.x) - pose.yaw):.1f}"
        f" path {one.path_m:.0f} m"
        for one in frontiers[:TOLD_FRONTIERS]
    )
    return "frontiers: " + "; ".join(told)


def _actions(memory: ExplorationMemory) -> str:
    last = (
        f"{one.tool.replace('_', ' ')} {(one.end or one.verdict.value).replace('_', ' ')}"
        for one in memory.actions[-3:]
    )
    return "last: " + ", ".join(last) if memory.actions else ""


def _rooms(memory: ExplorationMemory) -> str:
    return "rooms: " + ", ".join(plain(one.name) for one in memory.rooms[:5]) if memory.rooms else ""


def _found(memory: ExplorationMemory) -> str:
    return "found: " + ", ".join(plain(one.label) for one in memory.discoveries[-5:]) if memory.discoveries else ""


def _dead_ends(memory: ExplorationMemory) -> str:
    ends = ", ".join(f"{one.x_m:.0f} {one.y_m:.0f}" for one in memory.dead_ends[-3:])
    return f"dead ends: {ends}" if ends else ""
