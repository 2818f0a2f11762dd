"""How often a client may be wrong: wrong keys and failed log-ins count, right ones never."""

import time
from collections import OrderedDict, deque
from collections.abc import Callable
from ipaddress import IPv6Address, ip_address
from typing import Final

from starlette.requests import HTTPConnection

WRONG_A_MINUTE: Final = 10
MINUTE_S: Final = 60.0
CLIENTS_MAX: Final = 1000


class Attempts:
    """Of the clients that were wrong last: whoever has thousands of addresses fills no memory."""

    def __init__(
        self,
        wrong_a_minute: int = WRONG_A_MINUTE,
        *,
        clients_max: int = CLIENTS_MAX,
        now_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._wrong_a_minute = wrong_a_minute
        self._clients_max = clients_max
        self._now_s = now_s
        self._wrong_s: OrderedDict[str, deque[float]] = OrderedDict()

    def wrong(self, connection: HTTPConnection) -> bool:
        """Counts one more; False when the client has had its share."""
        client, now_s = _client(connection), self._now_s()
        wrong_s = self._wrong_s.setdefault(client, deque(maxlen=self._wrong_a_minute))
        self._wrong_s.move_to_end(client)
        if len(self._wrong_s) > self._clients_max:
            self._wrong_s.popitem(last=False)
        if len(wrong_s) == self._wrong_a_minute and now_s - wrong_s[0] < MINUTE_S:
            return False
        wrong_s.append(now_s)
        return True

    def not_wrong(self, connection: HTTPConnection) -> None:
        """Takes one back that was counted before it was known to be right."""
        if wrong_s := self._wrong_s.get(_client(connection)):
            wrong_s.pop()


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
