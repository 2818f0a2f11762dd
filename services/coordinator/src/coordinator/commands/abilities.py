"""What this robot can do of a wish: it sees and drives, and it has no arm. Pure."""

from typing import Final

from contracts.intent import WantedAction

NO_ARM: Final = {
    WantedAction.BRING: "I have no arm: I find it and drive up to it, I do not carry it",
    WantedAction.POUR: "I have no arm: I cannot pour. I can find it and drive up to it",
}


def what_it_cannot(action: WantedAction, *, unknown_room: str | None = None) -> str:
    """For a person; '' where it can do all of it. `unknown_room`: memory knows no room of that name to drive to."""
    if action is WantedAction.GO and unknown_room is not None:
        return f"I know no room called {unknown_room}: I can drive to a thing in it"
    return NO_ARM.get(action, "")
