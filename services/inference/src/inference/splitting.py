"""Cuts a command into the parts that each ask for one thing. Pure."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Part:
    """`said` are the command's own words; `meaning` is what to read, the same but where "the blue one" needs a noun."""

    said: str
    meaning: str


def split(command: str) -> tuple[Part, ...]:
    return (Part(command, command),)
