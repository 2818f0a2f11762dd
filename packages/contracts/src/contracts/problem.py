"""What every service answers when it cannot do what was asked, and how it tells its health."""

from enum import StrEnum

from pydantic import Field

from contracts.base import Message


class Problem(Message):
    """RFC 9457 problem details, sent as application/problem+json."""

    type: str = "about:blank"
    title: str
    status: int = Field(ge=400, le=599)
    detail: str = ""
    instance: str = ""
    code: str = Field(default="", description="which refusal this is, for a program: a member of an enum, or ''")


class DependencyState(StrEnum):
    READY = "ready"
    """Its data is flowing."""
    WARNING = "warning"
    """It works, and a person should know something about it."""
    NOT_READY = "not_ready"
    """It answers, and cannot do its work yet."""
    UNREACHABLE = "unreachable"
    """It does not answer."""


class Dependency(Message):
    """One thing a service needs: is its data flowing? `detail` is for a person, `state` for a program."""

    name: str
    state: DependencyState
    detail: str = ""

    @classmethod
    def of(cls, name: str, *, ok: bool, detail: str = "") -> "Dependency":
        """READY or NOT_READY."""
        return cls(name=name, state=DependencyState.READY if ok else DependencyState.NOT_READY, detail=detail)

    @property
    def ok(self) -> bool:
        return self.state in {DependencyState.READY, DependencyState.WARNING}


class Readiness(Message):
    ready: bool
    service: str
    dependencies: tuple[Dependency, ...] = ()


class Health(Message):
    status: str = "ok"
    service: str
