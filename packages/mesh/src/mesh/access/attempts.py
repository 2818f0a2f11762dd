"""How often a client may be wrong: wrong keys and failed log-ins count, right ones never."""

from typing import Final

from limits import RateLimitItemPerMinute
from limits.storage import MemoryStorage
from limits.strategies import MovingWindowRateLimiter
from starlette.requests import HTTPConnection

WRONG_A_MINUTE: Final = 10


class Attempts:
    def __init__(self, wrong_a_minute: int = WRONG_A_MINUTE) -> None:
        self._limit = RateLimitItemPerMinute(wrong_a_minute)
        self._limiter = MovingWindowRateLimiter(MemoryStorage())

    def wrong(self, connection: HTTPConnection) -> bool:
        """Counts one more; False when the client has had its share."""
        return self._limiter.hit(self._limit, _client(connection))

    def left(self, connection: HTTPConnection) -> bool:
        """Whether the client may still be wrong."""
        return self._limiter.test(self._limit, _client(connection))


def _client(connection: HTTPConnection) -> str:
    return connection.client.host if connection.client is not None else "unknown"
