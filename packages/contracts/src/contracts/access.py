"""Who may what: the roles, and the file of those who hold a key. It holds no secret, only what one is compared with."""

import hashlib
import hmac
from enum import StrEnum
from typing import Annotated, Self

from pydantic import Field, model_validator

from contracts.base import Message

CALLERS = ("coordinator", "inference", "memory", "robot_bridge", "speech", "ui")
"""Who has a key for other services and a user on the bus."""
PASSWORD_LENGTH_MAX = 200
"""Argon2 reads all of it: a longer one would cost whoever compares it, and protect nobody better."""


class Role(StrEnum):
    """What a route asks for and what a key is good for. In this order: each may also what those before it may."""

    VIEWER = "viewer"
    """Looks: pictures, map, memory, missions, state, metrics. Moves and changes nothing."""
    OPERATOR = "operator"
    """Sends the robot: missions, driving, docking, the reset of a stop, and forgetting what was remembered wrongly."""
    SERVICE = "service"
    """What only services ask of each other: sessions with the bridge, the models, what memory takes in."""
    ADMIN = "admin"
    """Everything; alone the drives' gains, deleting recordings, and replacing the memory on the page."""

    def may(self, needed: "Role") -> bool:
        order = tuple(Role)
        return order.index(self) >= order.index(needed)


Name = Annotated[
    str, Field(pattern=r"^[a-z0-9][a-z0-9_.-]{0,31}$", description="who holds the key; stands in logs and on the page")
]


class Principal(Message):
    """Somebody, or a service, with a role: by a key, by a password for the page, or by both."""

    name: Name
    role: Role
    key_sha256: str | None = Field(default=None, pattern=r"^[0-9a-f]{64}$", description="of the key; none = has none")
    password: str | None = Field(
        default=None, pattern=r"^\$argon2id\$", max_length=500, description="as Argon2 has it; for the page alone"
    )


class CredentialFile(Message):
    """`keys.json`, written by `atom keys` and read by every service."""

    principals: tuple[Principal, ...] = Field(default=(), max_length=1000)

    @model_validator(mode="after")
    def _names_are_unique(self) -> Self:
        names = [one.name for one in self.principals]
        if len(set(names)) != len(names):
            raise ValueError("two principals have the same name")
        return self


def sha256_of(key: str) -> str:
    """What the file keeps of a key. A key is 256 random bits: nothing slower is needed, and no salt."""
    return hashlib.sha256(key.encode()).hexdigest()


def bus_password_of(key: str) -> str:
    """A service's password at Redis, made of its key: there is one secret a service, and Redis never learns it."""
    return hmac.digest(key.encode(), b"atom bus", "sha256").hex()
