"""A stop that a controller has not confirmed is not forgotten: what is owed is asked for again. Pure."""

import math
import threading
from typing import Final

AGAIN_S: Final = 1.0
"""A controller that has not answered in this time is asked again."""


class OwedCancel:
    """A cancel of every goal of one controller. Owed from the start, since an earlier process may have left goals.

    Each `owe` is a new one: an answer to what was asked before it does not settle it, for a goal may have been
    accepted in between. `owe` and `owed` may be called from any thread.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._newest = 1
        self._settled = 0
        self._owed_since_s = -math.inf
        self._asked: tuple[int, float] | None = None
        self._was_there = False

    @property
    def owed(self) -> bool:
        return self._settled < self._newest

    def owed_for_s(self, now_s: float) -> float:
        """How long something has been owed; 0 where nothing is."""
        with self._lock:
            return now_s - self._owed_since_s if self.owed else 0.0

    def owe(self, now_s: float) -> None:
        with self._lock:
            if not self.owed:
                self._owed_since_s = now_s
            self._newest += 1

    def there(self, is_there: bool, now_s: float) -> None:
        """Whether the controller is in reach; what it does while it is not can be heard of by nobody."""
        if self._was_there and not is_there:
            self.owe(now_s)
        self._was_there = is_there

    def due(self, now_s: float) -> int | None:
        """What the controller is to be asked now, as a number for `answered`; none where nothing is to be asked."""
        with self._lock:
            waiting = self._asked is not None and self._asked[0] == self._newest and now_s - self._asked[1] < AGAIN_S
            if not self._was_there or not self.owed or waiting:
                return None
            self._asked = (self._newest, now_s)
            return self._newest

    def answered(self, number: int) -> None:
        """The controller has cancelled all that it had when it was asked for `number`."""
        with self._lock:
            self._settled = max(self._settled, number)
