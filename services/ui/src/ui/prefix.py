"""Below which path the page is reached: what a proxy says of it, checked, becomes ASGI's `root_path`.

Proxies say it with `X-Forwarded-Prefix` (Traefik; nginx by a line of its own) or `X-Ingress-Path` (Home Assistant), and
take it off the path of what they pass on, or leave it there.
"""

import re
from collections.abc import Iterable
from functools import lru_cache
from typing import Final

import structlog
from starlette.datastructures import Headers
from starlette.types import ASGIApp, Receive, Scope, Send

log = structlog.get_logger()

HEADERS: Final = ("x-forwarded-prefix", "x-ingress-path")
"""The first that is there counts."""
LENGTH_MAX: Final = 200
_SEGMENT: Final = re.compile(r"[A-Za-z0-9_~@-][A-Za-z0-9._~@-]*")


def prefix_of(said: Iterable[str]) -> str | None:
    """`/a/b` of what one header says, '' where it says nothing; None where it is no path of this host.

    Several values (nested proxies, the outermost first) are one path. Slashes at the end and doubled ones do not
    count, but one that begins with two names another host: no path. Nor are `..`, hidden or quoted characters.
    """
    parts = [part.strip() for value in said for part in value.split(",")]
    if any(part.startswith("//") for part in parts):
        return None
    segments = [segment for part in parts for segment in part.split("/") if segment]
    path = "".join(f"/{segment}" for segment in segments)
    return path if len(path) <= LENGTH_MAX and all(map(_SEGMENT.fullmatch, segments)) else None


class BelowPrefix:
    """ASGI middleware, the outermost: routes see `root_path` + their own path, whether or not the proxy took it off."""

    def __init__(self, app: ASGIApp, *, prefix: str = "") -> None:
        """`prefix` counts where no header says one: for a proxy that cannot."""
        self.app = app
        self.prefix = prefix_of([prefix]) or ""

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] in {"http", "websocket"}:
            scope = self._below(scope)
        await self.app(scope, receive, send)

    def _below(self, scope: Scope) -> Scope:
        headers = Headers(scope=scope)
        said = next((values for name in HEADERS if (values := headers.getlist(name))), None)
        prefix = self.prefix
        if said is not None:
            found = prefix_of(said)
            if found is None:
                _say_ignored(",".join(said)[:LENGTH_MAX])
            prefix = found if found is not None else self.prefix
        own = scope.get("root_path", "").rstrip("/")
        route = _without(prefix, _without(own, scope["path"]))
        root = prefix + own
        kept = [(name, value) for name, value in scope["headers"] if name.decode("latin-1").lower() not in HEADERS]
        return {**scope, "headers": kept, "root_path": root, "path": root + route}


def _without(prefix: str, path: str) -> str:
    return path[len(prefix) :] or "/" if path == prefix or path.startswith(f"{prefix}/") else path


@lru_cache(maxsize=32)
def _say_ignored(said: str) -> None:
    """Once a value, however often it comes."""
    log.warning("a prefix that is no path of this host is ignored", said=said)
