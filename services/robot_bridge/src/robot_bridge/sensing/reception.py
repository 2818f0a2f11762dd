"""What came and was not understood, sensor by sensor, and what is to be known of what was. Pure."""

from dataclasses import dataclass

TOLD_AGAIN_S = 30.0
"""So often at most does a sensor that is not understood fill a line of the log."""
REASON_CHARACTERS_MAX = 300


@dataclass(frozen=True, slots=True)
class Refusal:
    """The newest message of a sensor made no sense."""

    reason: str
    at_s: float


class Reception:
    """Written by the robot's thread, read by any: each entry is replaced whole."""

    def __init__(self) -> None:
        self._refused: dict[str, Refusal | None] = {}
        self._notes: dict[str, str] = {}
        self._told_s: dict[str, float] = {}

    def take(self, sensor: str, note: str = "") -> None:
        """A message was understood; `note` is what a person should know of it."""
        self._refused[sensor] = None
        self._notes[sensor] = note

    def refuse(self, sensor: str, reason: str, at_s: float) -> bool:
        """A message was not understood. Answers whether it is time to say so in the log."""
        self._refused[sensor] = Refusal(reason[:REASON_CHARACTERS_MAX], at_s)
        told_s = self._told_s.get(sensor)
        if told_s is not None and at_s - told_s < TOLD_AGAIN_S:
            return False
        self._told_s[sensor] = at_s
        return True

    def refused(self, sensor: str) -> Refusal | None:
        """Why the newest message was not understood; none when it was, or when there was none."""
        return self._refused.get(sensor)

    def note(self, sensor: str) -> str:
        return self._notes.get(sensor, "")

    def why_none(self, sensor: str, never: str) -> str:
        """Why there is no value: what came was not understood, or else `never`."""
        refused = self.refused(sensor)
        return f"{sensor} is received and not understood: {refused.reason}" if refused is not None else never
