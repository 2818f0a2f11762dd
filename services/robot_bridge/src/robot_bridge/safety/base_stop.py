"""The base's own emergency stop: when it is asked for, when it is let go, and what the wheels say of it. Pure.

Asked for on the edge, a bounded number of times, until the wheels say that they are disabled: a service may answer
anything. Let go once, on the edge of a person's reset, and never where the base was stopped at the robot itself.
"""

import math

from contracts.robot import BaseStopState

ASKS_MAX = 4
ANSWER_S_MAX = 2.5
"""How long an ask may take to show in the wheels before it is repeated."""
ECHO_S_MAX = 5.0
"""How long after an ask the wheels' change is put down to it."""


class BaseStop:
    """One thread calls it. `due` says what to ask the base for now; `state` what to tell."""

    def __init__(self) -> None:
        self.enabled: bool | None = None
        """What the wheels said last; None before they said anything."""
        self._latched = False
        self._there = False
        self._asks_left = 0
        self._asked_since_edge = False
        self._asked_s = -math.inf
        self._release = False
        self._ours = False
        """Whether the wheels are disabled because this bridge, or the one before it, asked for it."""

    def stopped(self, *, restored: bool = False) -> None:
        """The bridge's stop was pressed, or found latched at the start (`restored`: an earlier bridge asked for it)."""
        self._latched, self._release = True, False
        self._ours = self._ours or restored
        self._begin_asking()

    def reset(self) -> None:
        """A person's reset. A base that is away, or was stopped at the robot, is not told to let go."""
        held = self.enabled is False and not self._ours
        self._release = self._latched and self._there and not held
        self._latched = False

    def there(self, is_there: bool) -> None:
        """Whether the base's service can be called. One that comes back while latched may know nothing of it."""
        if is_there and not self._there and self._latched:
            self._begin_asking()
        self._there = is_there

    def heard(self, enabled: bool, now_s: float) -> None:
        """What the wheels say. A base let go at the robot while the bridge's stop is latched is asked anew."""
        if enabled:
            if self._latched and self.enabled is False:
                self._begin_asking()
            self._ours = False
        elif self.enabled is not False:
            self._ours = self._latched or now_s - self._asked_s <= ECHO_S_MAX
        self.enabled = enabled

    def due(self, now_s: float) -> bool | None:
        """What to ask the base for now (True: stop), told once; None: nothing."""
        if self._release:
            self._release, self._asked_s = False, now_s
            return False
        if not (self._latched and self._there and self._asks_left) or self._confirmed:
            return None
        if self._asked_since_edge and now_s - self._asked_s < ANSWER_S_MAX:
            return None
        self._asks_left -= 1
        self._asked_since_edge, self._asked_s = True, now_s
        return True

    def state(self, now_s: float) -> BaseStopState:
        if not self._latched:
            if self.enabled is None:
                return BaseStopState.UNKNOWN
            letting_go = self._ours and now_s - self._asked_s <= ECHO_S_MAX
            return BaseStopState.RELEASED if self.enabled or letting_go else BaseStopState.HELD
        if self._confirmed:
            return BaseStopState.ENGAGED
        if not self._there:
            return BaseStopState.MISSING
        waiting = self._asks_left > 0 or now_s - self._asked_s < ANSWER_S_MAX
        return BaseStopState.ASKED if waiting else BaseStopState.UNCONFIRMED

    @property
    def _confirmed(self) -> bool:
        return self._asked_since_edge and self.enabled is False

    def _begin_asking(self) -> None:
        self._asks_left, self._asked_since_edge = ASKS_MAX, False
