"""Waiting until every part of the mesh is ready, and saying what is still missing."""

import time
from collections.abc import Callable

import httpx
from pydantic import ValidationError

from contracts.problem import Readiness
from demo.stack import Ports, Stack, StackError


def parts_of(stack: Stack) -> tuple[str, ...]:
    """Whatever has to be ready."""
    return ("truth", *stack.calls)


def missing(client: httpx.Client, ports: Ports, part: str) -> str | None:
    """None when the part is ready; else what it lacks, in words."""
    try:
        answer = client.get(f"{ports.url(part)}/ready", timeout=2.0)
    except httpx.HTTPError:
        return "not answering yet"
    try:
        readiness = Readiness.model_validate_json(answer.content)
    except ValidationError:
        return f"HTTP {answer.status_code}"
    if readiness.ready:
        return None
    return ", ".join(f"{d.name} ({d.detail})" if d.detail else d.name for d in readiness.dependencies if not d.ok)


def wait_until_ready(
    stack: Stack, *, timeout_s: float, on_ready: Callable[[str, float], None], alive: Callable[[], bool]
) -> float:
    """Returns the seconds it took. Raises StackError naming what is missing when the time is over."""
    started = time.monotonic()
    lacking: dict[str, str] = dict.fromkeys(parts_of(stack), "not asked yet")
    with httpx.Client(trust_env=False) as client:
        while lacking:
            for part in tuple(lacking):
                lack = missing(client, stack.ports, part)
                if lack is None:
                    del lacking[part]
                    on_ready(part, time.monotonic() - started)
                else:
                    lacking[part] = lack
            if not alive():
                raise StackError("the supervisor ended; see its log")
            if lacking and time.monotonic() - started > timeout_s:
                told = "; ".join(f"{part} lacks {lack}" for part, lack in lacking.items())
                raise StackError(f"not ready after {timeout_s:.0f} s: {told}")
            time.sleep(0.2 if lacking else 0.0)
    return time.monotonic() - started
