"""Which of a home's rooms a person means, and in which a thing stands, by memory's rooms. Pure."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from contracts.memory import RememberedObject
from contracts.rooms import NamedBy, NamedRoom
from vocabulary.rooms import called


@dataclass(frozen=True, slots=True)
class KnownRooms:
    """Those of the map the robot is in; none where memory knows none."""

    rooms: tuple[NamedRoom, ...] = ()
    map_id: str | None = None
    """Of the home they are of; none where memory does not say."""

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(one.name for one in self.rooms)

    def meant(self, said: str) -> tuple[NamedRoom, ...]:
        """The room of that name; where none bears it, those of that kind ('the bedroom', where there are two)."""
        named = [one for one in self.rooms if one.name.casefold() == said.casefold()]
        of_kind = [one for one in self.rooms if one.kind == said and one.named_by is not NamedBy.NOBODY]
        exact = [one for one in named if one.named_by is NamedBy.PERSON]
        return tuple(exact or of_kind or named)

    def where(self, thing: RememberedObject) -> str:
        """', in the kitchen'; '' where its room is not known."""
        name = next((one.name for one in self.rooms if one.id == thing.room_id), None)
        return "" if name is None else f", in {called(name)}"


def inside(things: Iterable[RememberedObject], rooms: Sequence[NamedRoom]) -> list[RememberedObject]:
    """Those that stand in one of the rooms."""
    ids = {one.id for one in rooms}
    return [one for one in things if one.room_id in ids]
