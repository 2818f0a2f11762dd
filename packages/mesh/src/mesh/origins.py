"""Where a page comes from and where it asks: `Origin` and `Host`, whichever way they are written."""

import contextlib
import socket
from collections.abc import Collection
from ipaddress import ip_address
from typing import NamedTuple

import httpx

PORTS = {"http": 80, "https": 443}
"""Of the schemes of pages; a page of another scheme (file, an extension) is at home nowhere."""


LOCAL_ENDINGS = (".local", ".localhost", ".lan", ".internal", ".home.arpa")
"""Of names that nobody can buy."""
THIS_MACHINE = socket.gethostname().lower()


class Place(NamedTuple):
    host: str
    port: int


def place_of_origin(origin: str) -> tuple[str, Place] | None:
    """Scheme and place of an `Origin`; none where it names no place ('null', a file), or more than one."""
    url = _url(origin)
    if url is None or url.scheme not in PORTS:
        return None
    return url.scheme, _place(url, url.scheme)


def place_of_host(host: str, scheme: str) -> Place | None:
    """The place in a `Host`, asked by a page of `scheme`: without a port it means that scheme's own."""
    url = _url(f"{scheme}://{host}")
    return None if url is None else _place(url, scheme)


def ours_to_answer(host: str, names: Collection[str]) -> bool:
    """Whether a `Host` is one that this service can go by: an address, a name of the local network, or one of `names`.

    A page of the internet whose name is suddenly said to lie here (DNS rebinding) asks by that name: it has a dot and a
    public ending. A name without a dot is a container's, or this machine's own.
    """
    place = place_of_host(host, "http")
    if place is None:
        return False
    with contextlib.suppress(ValueError):
        ip_address(place.host)
        return True
    return "." not in place.host or place.host.endswith(LOCAL_ENDINGS) or place.host in {THIS_MACHINE, *names}


def _url(text: str) -> httpx.URL | None:
    """A URL of scheme, host and port, and nothing else."""
    try:
        url = httpx.URL(text)
    except httpx.InvalidURL:
        return None
    more = url.userinfo or url.query or url.fragment or url.path not in ("", "/") or "%20" in url.host
    return url if url.host and not more else None


def _place(url: httpx.URL, scheme: str) -> Place:
    """A name ends without its dot, in lower case; an address is written in one way, without its zone."""
    host = url.host.removesuffix(".").lower()
    with contextlib.suppress(ValueError):
        host = str(ip_address(host.split("%")[0]))
    return Place(host, url.port or PORTS[scheme])
