"""What the page is told of a spoken saying: its words, what they may mean, and whether they stopped the robot."""

import asyncio
from typing import Final, Self

from pydantic import Field

from contracts.base import Message
from contracts.intent import Understood
from contracts.speech import Hearing, Transcript
from mesh.errors import MeshError
from ui.latest_facts import Remembered
from ui.operator_actions import COMMAND_MAX
from ui.ports import Missions
from vocabulary.hot_words import sayable

UNDERSTOOD_S: Final = 3.0
"""So long the coordinator may take to say what was meant: a person waits for it who has just spoken."""


class Offer(Message):
    """One thing that may have been meant."""

    text: str = Field(description="for a person: 'bring the blue cup'")
    command: str = Field(description="what is sent when it is chosen")


class Saying(Message):
    """One message to the page: the newest reading; the final one says what it means."""

    final: bool
    heard_out: bool = Field(
        default=False, description="nothing more is listened to: the microphone is shut, what was meant may come later"
    )
    text: str = Field(description="as it sounded; empty when nobody spoke")
    stopped: bool | None = Field(
        default=None, description="a stop was heard, and reached the robot, or did not; none = no stop"
    )
    command: str = Field(
        default="", description="what to put in the box; empty where a person must choose, or nobody spoke"
    )
    question: str = Field(default="", description="for a person: 'the blue cup or the blue cap?'")
    offers: tuple[Offer, ...] = Field(default=(), description="what it may mean, the likeliest first")

    @classmethod
    def of(cls, hearing: Hearing, *, stopped: bool | None) -> Self:
        """Never final: what it means is not known yet."""
        return cls(final=False, heard_out=hearing.final, text=hearing.transcript.text, stopped=stopped)


def hot_words_of(remembered: Remembered) -> list[str]:
    """Names that memory holds, the most believed first."""
    things = sorted(remembered.objects, key=lambda one: one.belief, reverse=True)
    return sayable([*(one.label for one in things), *(one.label for one in remembered.labels)])


async def understood_of(transcript: Transcript, missions: Missions) -> Understood | None:
    """What the readings mean; none where the coordinator is away, or takes longer than `UNDERSTOOD_S`."""
    try:
        async with asyncio.timeout(UNDERSTOOD_S):
            return await missions.understand(_readings(transcript))
    except (MeshError, TimeoutError):
        return None


def meant(heard: Saying, transcript: Transcript, understood: Understood | None) -> Saying:
    """`heard` with what it means. Where nobody could say, the readings themselves are offered."""
    readings = _readings(transcript)
    if understood is None:
        return heard.model_copy(update=_unread(readings, agree=transcript.agree))
    return heard.model_copy(update=_read(readings, understood))


def _readings(transcript: Transcript) -> tuple[str, ...]:
    """The one with our names expected first, each once."""
    said = (_printable(transcript.hot_text), _printable(transcript.text))
    return tuple(dict.fromkeys(one for one in said if one))


def _printable(text: str) -> str:
    """As the coordinator takes it."""
    return "".join(one if one.isprintable() else " " for one in text).strip()[:COMMAND_MAX]


def _read(readings: tuple[str, ...], understood: Understood) -> dict[str, object]:
    if understood.intent is not None:
        return {"command": understood.intent.command}
    offers = tuple(Offer(text=one.text, command=one.intent.command) for one in understood.choices)
    if not offers:
        return {"command": readings[0], "question": understood.question}
    return {"question": understood.question, "offers": offers}


def _unread(readings: tuple[str, ...], *, agree: bool) -> dict[str, object]:
    if agree or len(readings) == 1:
        return {"command": readings[0]}
    return {"offers": tuple(Offer(text=one, command=one) for one in readings)}
