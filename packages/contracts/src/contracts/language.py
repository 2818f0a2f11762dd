"""Putting facts into words: the language model phrases, the facts come from the services."""

from typing import Annotated

from pydantic import Field, StringConstraints

from contracts.base import NO_CONTROL_CHARACTERS, Message

Fact = Annotated[str, Field(min_length=1, max_length=300)]
Phrase = Annotated[
    str, StringConstraints(strip_whitespace=True, min_length=1, max_length=1000, pattern=NO_CONTROL_CHARACTERS)
]


class ReasonRequest(Message):
    """A question, and everything its answer may be made of. Answered with 503 where no language model can."""

    question: str = Field(min_length=1, max_length=500)
    facts: tuple[Fact, ...] = Field(min_length=1, max_length=40, description="one sentence each; nothing else is known")


class ReasonReply(Message):
    """Nothing is named and no number given in `answer` that the question and the facts do not hold."""

    answer: Phrase
    by: str = Field(description="who phrased it: 'ollama:<model>' or 'openai:<model>'")
    took_ms: float = Field(default=0.0, ge=0.0)
