"""The hours in which it says nothing: '22:00-07:00'. Pure."""

import re
from dataclasses import dataclass
from datetime import time
from typing import Self

_WRITTEN = re.compile(r"([01]\d|2[0-3]):([0-5]\d)-([01]\d|2[0-3]):([0-5]\d)")


@dataclass(frozen=True, slots=True)
class QuietHours:
    """From `begin` until `end`, over midnight where that is earlier; the same twice = the whole day."""

    begin: time
    end: time

    @classmethod
    def read(cls, written: str) -> Self | None:
        """None where nothing is written. Raises `ValueError`."""
        if not written.strip():
            return None
        found = _WRITTEN.fullmatch(written.strip())
        if found is None:
            raise ValueError(f"{written!r} is no stretch of the day: write it as 22:00-07:00")
        begin_h, begin_min, end_h, end_min = (int(one) for one in found.groups())
        return cls(time(begin_h, begin_min), time(end_h, end_min))

    def covers(self, now: time) -> bool:
        """`now` is the time of day where the robot is."""
        if self.begin < self.end:
            return self.begin <= now < self.end
        return now >= self.begin or now < self.end
