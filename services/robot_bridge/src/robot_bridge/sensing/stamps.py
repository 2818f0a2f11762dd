"""When a message was taken, and whether it is new: one rule for every stream that carries stamps. Pure.

All that the bridge compares lies on its own clock. Where the base's clock (that of its odometry) is another, its stamps
are put on the bridge's by the difference, and those of all streams that agree with it. A stamp that is zero, or of a
clock that agrees with neither, or far off on its own, is not believed: the moment it came is taken, and that is said.

A message is new unless it repeats the stamp of the last: then a frozen sensor sends the same measurement again.
"""

import statistics
from collections import deque
from dataclasses import dataclass

APART_S_MAX = 1.0
"""Clocks further apart are two clocks; nearer, the difference is taken for the time under way."""
LATE_S_MAX = 5.0
"""A single message may have been under way this long and still be believed."""
AHEAD_S_MAX = 0.5
SAMPLES = 15
SILENT_S = 10.0
"""The clock of who has been silent for longer is not compared."""
TF = "tf"
TF_AHEAD_S_MAX = 2.0
"""AMCL dates its correction ahead, by its transform_tolerance (1 s by default)."""
BASE = "odom"
"""Whose clock is the robot's: poses are looked up by it."""
STEP_S = 0.3
"""Less is the way of the messages, and jitter."""
THIS_COMPUTER = "this computer"


@dataclass(frozen=True, slots=True)
class Moment:
    """When it was taken, on the bridge's clock; `note` says why that is not the stamp it came with."""

    stamp_s: float
    note: str = ""


class StreamClock:
    """One publisher's clock, as its stamps tell it."""

    def __init__(self, *, ahead_s_max: float = AHEAD_S_MAX) -> None:
        self.ahead_s_max = ahead_s_max
        self.heard_s = float("-inf")
        self._last_stamp_s: float | None = None
        self._behind_s: deque[float] = deque(maxlen=SAMPLES)

    def is_new(self, stamp_s: float, received_s: float) -> bool:
        """Notes it; false where it is the last measurement again."""
        if stamp_s <= 0.0:
            return True
        if stamp_s == self._last_stamp_s:
            return False
        self._last_stamp_s, self.heard_s = stamp_s, received_s
        self._behind_s.append(received_s - stamp_s)
        return True

    def moment(self, stamp_s: float, received_s: float, base_behind_s: float) -> Moment:
        """On the bridge's clock, which is `base_behind_s` ahead of the base's."""
        if stamp_s <= 0.0:
            return Moment(received_s, "it carries no time: the time of arrival is taken")
        clock_s, message_s = self.behind_s - base_behind_s, received_s - stamp_s - base_behind_s
        if not -self.ahead_s_max <= clock_s <= APART_S_MAX:
            return Moment(received_s, f"its clock is {apart(clock_s)} the robot's: the time of arrival is taken")
        if not -self.ahead_s_max <= message_s <= LATE_S_MAX:
            return Moment(received_s, f"a stamp was {apart(message_s)} its arrival: the time of arrival is taken")
        return Moment(stamp_s + base_behind_s)

    @property
    def behind_s(self) -> float:
        """How far the clock lies behind the bridge's, the way of the messages included: the median of the last few."""
        return statistics.median(self._behind_s) if self._behind_s else 0.0


class Clocks:
    """The clocks of all streams, by sensor. `simulated`: the robot keeps a time of its own, and that is well."""

    def __init__(self) -> None:
        self.simulated = False
        self._base_behind_s = 0.0
        self._streams: dict[str, StreamClock] = {}

    def moment(self, sensor: str, stamp_s: float, received_s: float) -> Moment | None:
        """When this message of the sensor was taken; none where it is the last measurement again."""
        stream = self._streams.get(sensor)
        if stream is None:
            stream = StreamClock(ahead_s_max=TF_AHEAD_S_MAX if sensor == TF else AHEAD_S_MAX)
            self._streams = self._streams | {sensor: stream}
        if not stream.is_new(stamp_s, received_s):
            return None
        if sensor == BASE:
            self._follow(stream.behind_s)
        return stream.moment(stamp_s, received_s, self._base_behind_s)

    def on_bridge_s(self, stamp_s: float, received_s: float) -> float:
        """The moment of a message on its own, of whose clock nothing is known."""
        put_s = stamp_s + self._base_behind_s
        near = stamp_s > 0.0 and -TF_AHEAD_S_MAX <= received_s - put_s <= LATE_S_MAX
        return put_s if near else received_s

    def _follow(self, behind_s: float) -> None:
        """The base's clock is taken for the bridge's while it may be, and else followed in steps, not in every jitter:
        time that jumps costs the history of poses."""
        if abs(behind_s) <= STEP_S:
            self._base_behind_s = 0.0
        elif abs(behind_s - self._base_behind_s) > STEP_S:
            self._base_behind_s = behind_s

    def odd(self, now_s: float) -> dict[str, float]:
        """Those that do not agree with most, and by how many seconds they are behind them (negative: ahead)."""
        streams = {name: one for name, one in self._streams.items() if now_s - one.heard_s < SILENT_S}
        behind_s = {name: one.behind_s for name, one in streams.items()}
        if not self.simulated:
            behind_s = {THIS_COMPUTER: 0.0} | behind_s
        if not behind_s:
            return {}

        def agree(name: str, reference_s: float) -> bool:
            ahead_s_max = max(APART_S_MAX, streams[name].ahead_s_max if name in streams else 0.0)
            return -ahead_s_max <= behind_s[name] - reference_s <= APART_S_MAX

        reference_s = max(behind_s.values(), key=lambda one: sum(agree(name, one) for name in behind_s))
        return {name: value - reference_s for name, value in behind_s.items() if not agree(name, reference_s)}


def apart(behind_s: float) -> str:
    """In words: '3.0 s behind', '1.2 h ahead of'."""
    size_s, side = abs(behind_s), "behind" if behind_s > 0.0 else "ahead of"
    for unit, unit_s in (("years", 31_557_600.0), ("days", 86_400.0), ("h", 3600.0)):
        if size_s >= 2.0 * unit_s:
            return f"{size_s / unit_s:.1f} {unit} {side}"
    return f"{size_s:.1f} s {side}"
