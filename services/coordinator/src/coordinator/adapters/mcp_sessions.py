"""Who has how many MCP sessions open, so that no principal can take all of them. Pure: time comes from outside."""

from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass


@dataclass(slots=True)
class _Open:
    who: str
    used_s: float
    requests: int = 0
    """Of its requests, those that are being served."""


@dataclass(frozen=True, eq=False)
class OpeningRequest:
    """A request that may open a session."""

    who: str


class McpSessions:
    """What the session manager has open, told by its own answers: it does not say itself whose its sessions are."""

    def __init__(self, *, idle_s: float) -> None:
        """`idle_s`: the manager ends one of which no request has been served for so long."""
        self._idle_s = idle_s
        self._open: dict[str, _Open] = {}
        self._opening: list[OpeningRequest] = []

    def of(self, who: str, now_s: float) -> int:
        """How many are open, or being opened."""
        over = [each for each, one in self._open.items() if not one.requests and now_s - one.used_s >= self._idle_s]
        for each in over:
            del self._open[each]
        return sum(one.who == who for one in (*self._opening, *self._open.values()))

    @contextmanager
    def opening(self, who: str) -> Generator[OpeningRequest]:
        """While the request lasts that may open one."""
        one = OpeningRequest(who)
        self._opening.append(one)
        try:
            yield one
        finally:
            if one in self._opening:
                self._opening.remove(one)

    def opened(self, one: OpeningRequest, session: str, now_s: float) -> None:
        """From now on it counts as that session, though the answer to what opened it may last."""
        self._opening.remove(one)
        self._open[session] = _Open(one.who, now_s)

    def begin_request(self, session: str) -> None:
        if (one := self._open.get(session)) is not None:
            one.requests += 1

    def end_request(self, session: str, now_s: float) -> None:
        if (one := self._open.get(session)) is not None:
            one.requests -= 1
            one.used_s = now_s

    def closed(self, session: str) -> None:
        self._open.pop(session, None)
