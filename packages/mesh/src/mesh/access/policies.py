"""What each route, socket and mount of an app declares: the role it needs, or that it is public.

Undeclared is an error at start: a route that nobody thought of would else stand open.
"""

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Final, TypeVar

from fastapi.routing import iter_route_contexts
from starlette.routing import BaseRoute, Mount, WebSocketRoute

from contracts.access import Role

T = TypeVar("T")

_MARK: Final = "__atom_role__"
SOCKET: Final = "WS"
ANY: Final = "any"
"""The method of a mount: whatever is asked of what lies below."""


class NotDeclaredError(Exception):
    """Names the routes that say neither who may nor that all may."""


def requires_role(role: Role) -> Callable[[T], T]:
    """Below the route's decorator, or round the app of a mount: who asks has this role or a higher one."""

    def declared(target: T) -> T:
        setattr(target, _MARK, role)
        return target

    return declared


def public(target: T) -> T:
    """Whoever reaches it may. Used for what stops the robot, tells that it lives, or lets a person in."""
    setattr(target, _MARK, None)
    return target


@dataclass(frozen=True, slots=True)
class RoutePolicy:
    """A method (`WS` of a socket, `any` of a mount) and a path, and who may; no role = public."""

    method: str
    path: str
    role: Role | None
    pattern: re.Pattern[str]


def route_policies(routes: Iterable[BaseRoute]) -> tuple[RoutePolicy, ...]:
    """In the order in which routes are matched. Raises `NotDeclaredError`."""
    found = tuple(_policies(routes))
    if missing := [f"{method} {path}" for method, path, policy in found if policy is None]:
        raise NotDeclaredError(f"neither requires_role nor public: {', '.join(missing)}")
    return tuple(policy for _, _, policy in found if policy is not None)


def _policies(routes: Iterable[BaseRoute]) -> Iterator[tuple[str, str, RoutePolicy | None]]:
    for one in iter_route_contexts(list(routes)):
        route = one.route
        target: Any = route.app if isinstance(route, Mount) else one.endpoint
        role = getattr(target, _MARK, ...)
        path = one.path_format or "/"
        for method in _methods(route, one.methods):
            yield method, path, None if role is ... else RoutePolicy(method, path, role, one.path_regex)


def _methods(route: BaseRoute, methods: Iterable[str] | None) -> tuple[str, ...]:
    if isinstance(route, WebSocketRoute):
        return (SOCKET,)
    return (ANY,) if isinstance(route, Mount) or not methods else tuple(sorted(methods))
