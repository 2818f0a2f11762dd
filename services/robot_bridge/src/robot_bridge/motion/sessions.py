"""Sessions: what a client asked for ends with its connection, or with its silence. Pure: time is passed in."""

import threading
import uuid
from collections import OrderedDict
from dataclasses import dataclass

from contracts.causes import Refusal
from mesh.errors import ConflictError, TooManyError

SESSIONS_MAX = 64
FIRST_BEAT_S = 1.0
"""A client that has just connected may be still starting."""


@dataclass(slots=True)
class _Session:
    heard_s: float
    has_beaten: bool = False


class Sessions:
    """Open sessions by id. Any thread: the robot's thread notices silence even when asyncio is busy."""

    def __init__(self, *, timeout_s: float) -> None:
        self._timeout_s = timeout_s
        self._first_beat_s = max(timeout_s, FIRST_BEAT_S)
        self._lock = threading.Lock()
        self._open: OrderedDict[str, _Session] = OrderedDict()

    def open(self, now_s: float) -> str:
        with self._lock:
            if len(self._open) >= SESSIONS_MAX:
                raise TooManyError(f"{SESSIONS_MAX} sessions are open")
            session_id = uuid.uuid4().hex
            self._open[session_id] = _Session(now_s)
            return session_id

    def beat(self, session_id: str, now_s: float) -> bool:
        """False when the session has ended; it cannot be revived."""
        with self._lock:
            if (session := self._open.get(session_id)) is None:
                return False
            session.heard_s = now_s
            session.has_beaten = True
            return True

    def end(self, session_id: str) -> bool:
        """True when it was open until now."""
        with self._lock:
            return self._open.pop(session_id, None) is not None

    def is_open(self, session_id: str) -> bool:
        with self._lock:
            return session_id in self._open

    def check(self, session_id: str | None) -> None:
        """Raises `ConflictError` for an ended or unknown session; a request without one is bound to none."""
        if session_id is not None and not self.is_open(session_id):
            raise ConflictError("the session is unknown or has ended", code=Refusal.SESSION_OVER)

    def end_silent(self, now_s: float) -> tuple[str, ...]:
        """Ends and returns the sessions not heard of for the timeout."""
        with self._lock:
            silent = tuple(i for i, s in self._open.items() if now_s - s.heard_s > self._patience_s(s))
            for session_id in silent:
                del self._open[session_id]
            return silent

    def _patience_s(self, session: _Session) -> float:
        return self._timeout_s if session.has_beaten else self._first_beat_s
