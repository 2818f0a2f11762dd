"""What every service answers when it cannot do what was asked, and how it tells its health."""

from pydantic import Field

from contracts.base import Message


class Problem(Message):
    """RFC 9457 problem details, sent as application/problem+json."""

    type: str = "about:blank"
    title: str
    status: int = Field(ge=400, le=599)
    detail: str = ""
    instance: str = ""


class Dependency(Message):
    """One thing a service needs: is its data flowing?"""

    name: str
    ok: bool
    detail: str = ""


class Readiness(Message):
    ready: bool
    service: str
    dependencies: tuple[Dependency, ...] = ()


class Health(Message):
    status: str = "ok"
    service: str
