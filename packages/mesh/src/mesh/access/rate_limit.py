"""How often a client may be wrong: wrong keys and failed log-ins count, right ones never."""

import time
from collections import OrderedDict, deque
from collections.abc import Callable
from ipaddress import IPv6Address, ip_address
from typing import Final

from starlette.requests import HTTPConnection

FAILURES_A_MINUTE: Final = 10
MINUTE_S: Final = 60.0
CLIENTS_MAX: Final = 1000


class FailureRateLimit:
    """Of the clients that were wrong last: whoever has thousands of addresses fills no memory."""

    def __init__(
        self,
        failures_a_minute: int = FAILURES_A_MINUTE,
        *,
        clients_max: int = CLIENTS_MAX,
        now_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._failures_a_minute = failures_a_minute
        self._clients_max = clients_max
        self._now_s = now_s
        self._failures_s: OrderedDict[str, deque[float]] = OrderedDict()

    def hit(self, connection: HTTPConnection) -> bool:
        """Counts one more; False when the client has had its share."""
        client, now_s = _client(connection), self._now_s()
        failures_s = self._failures_s.setdefault(client, deque(maxlen=self._failures_a_minute))
        self._failures_s.move_to_end(client)
        if len(self._failures_s) > self._clients_max:
            self._failures_s.popitem(last=False)
        if len(failures_s) == self._failures_a_minute and now_s - failures_s[0] < MINUTE_S:
            return False
        failures_s.append(now_s)
        return True

    def take_back(self, connection: HTTPConnection) -> None:
        """Takes one back that was counted before it was known to be right."""
        if failures_s := self._failures_s.get(_client(connection)):
            failures_s.pop()


def _client(connection: HTTPConnection) -> str:
    """An IPv6 client is its network of 64 bits: it may have any address in there."""
    host = connection.client.host if connection.client is not None else "unknown"
    try:
        address = ip_address(host)
    except ValueError:
        return host
    if not isinstance(address, IPv6Address):
        return host
    return str(address.ipv4_mapped or int(address) >> 64)
