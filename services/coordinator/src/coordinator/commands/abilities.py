"""What this robot can do of a wish: it sees and drives, it has no arm, and its maps name no rooms. Pure."""

from typing import Final

from contracts.intent import WantedAction

NO_ARM: Final = {
    WantedAction.BRING: "I have no arm: I find it and drive up to it, I do not carry it",
    WantedAction.POUR: "I have no arm: I cannot pour. I can find it and drive up to it",
}


def what_it_cannot(action: WantedAction, *, to_room: str | None = None) -> str:
    """For a person; '' where it can do all of it. `to_room`: the place asked for is a room and no thing."""
    if action is WantedAction.GO and to_room is not None:
        return f"my map names no rooms: I can drive to a thing in the {to_room}"
    return NO_ARM.get(action, "")
