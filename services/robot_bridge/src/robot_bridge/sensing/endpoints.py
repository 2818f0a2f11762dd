"""Who else speaks on the bridge's topics, and whether in the same types. Pure.

Another type's messages never arrive; those of another version of the same type do, and are misread: Fast DDS matches by
name alone.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum

from contracts.problem import Dependency, DependencyState

NAME = "types"


@dataclass(frozen=True, slots=True)
class Endpoint:
    """Somebody's end of a topic; `version` is the hash of the type's definition, '' where the middleware shows none."""

    topic: str
    node: str
    kind: str
    version: str = ""


class Difference(StrEnum):
    KIND = "kind"
    """Another type: nothing of it arrives."""
    VERSION = "version"
    """The type's definition is another one: what arrives is misread."""


@dataclass(frozen=True, slots=True)
class Mismatch:
    theirs: Endpoint
    ours: Endpoint
    difference: Difference
    alone: bool
    """Nobody else is on that topic with the right type."""


def difference(ours: Endpoint, theirs: Endpoint) -> Difference | None:
    if theirs.kind != ours.kind:
        return Difference.KIND
    shown = bool(theirs.version and ours.version)
    return Difference.VERSION if shown and theirs.version != ours.version else None


def mismatches(ours: Endpoint, others: Iterable[Endpoint]) -> tuple[Mismatch, ...]:
    """Of the others' ends of one topic, those that do not fit."""
    judged = [(each, difference(ours, each)) for each in others]
    alone = all(wrong is not None for _, wrong in judged)
    return tuple(Mismatch(each, ours, wrong, alone) for each, wrong in judged if wrong is not None)


def dependency(found: tuple[Mismatch, ...]) -> Dependency:
    """A stranger beside somebody who speaks rightly is a warning; one who is misread, or is alone, keeps from ready."""
    if not found:
        return Dependency(name=NAME, state=DependencyState.READY, detail="everybody speaks in the same types")
    grave = any(each.alone or each.difference is Difference.VERSION for each in found)
    state = DependencyState.NOT_READY if grave else DependencyState.WARNING
    return Dependency(name=NAME, state=state, detail="; ".join(in_words(each) for each in found))


def in_words(mismatch: Mismatch) -> str:
    theirs, ours = mismatch.theirs, mismatch.ours
    match mismatch.difference:
        case Difference.KIND:
            return f"{theirs.topic}: {theirs.node} has {theirs.kind}, this bridge {ours.kind}"
        case Difference.VERSION:
            return (
                f"{theirs.topic}: {theirs.node} has another version of {theirs.kind} than this bridge (another ROS "
                "release): it would be misread"
            )
