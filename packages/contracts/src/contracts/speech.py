"""What the speech service says: what was heard, and which voices speak."""

from enum import StrEnum
from typing import Annotated

from pydantic import Field

from contracts.base import Message

RATE_HZ = 16_000
"""Samples a second of all sound that is sent to `WS /listen`."""
HEARD_CHARACTERS_MAX = 1000
SPOKEN_CHARACTERS_MAX = 500
HOT_WORDS_MAX = 32
NOT_HELD = "not held"
"""Text to `WS /listen?held=true`: the button was only tapped, silence ends what is said from now on."""

HotWord = Annotated[
    str,
    Field(
        min_length=1,
        max_length=40,
        pattern=r"^[^\W_][\w '’.&-]*$",
        description="the name of a thing as people say it: letters, digits, spaces, apostrophe, dot, & and hyphen",
    ),
]

HeardText = Annotated[str, Field(max_length=HEARD_CHARACTERS_MAX)]
VoiceName = Annotated[str, Field(min_length=1, max_length=64, description="as `GET /voices` names it")]


class SpeechRefusal(StrEnum):
    """Why sound was not listened to: the `code` of the problem, the reason of a closed socket."""

    NOT_WAV = "not_wav"
    """Neither WAV nor said to be raw PCM."""
    TRUNCATED = "truncated"
    """It ends before the length its header tells, or in the middle of a sample."""
    UNSUPPORTED_CODING = "unsupported_coding"
    """A WAV, but not of plain 16-bit integers."""
    UNSUPPORTED_RATE = "unsupported_rate"
    """Samples a second, or channels, out of range."""
    TOO_SHORT = "too_short"
    TOO_LONG = "too_long"
    HOT_WORDS = "hot_words"
    """More than `HOT_WORDS_MAX`, or one that is no `HotWord`."""
    BUSY = "busy"
    """Others are being listened to: try again in a second."""


class Transcript(Message):
    """Two readings of the same sound. Show the plain one, parse the one with hot words, ask back where they differ."""

    text: HeardText = Field(description="the plain reading; empty when nobody spoke")
    hot_text: HeardText = Field(description="the reading that leans towards names of things; empty when nobody spoke")
    agree: bool = Field(description="both readings hold the same words, whatever their case and punctuation")
    stop: bool = Field(
        description="a reading is an order to stop, in any language `vocabulary.orders` knows: act at once. Of more "
        "than 3.5 s of sound the plain reading alone is looked at; 'wait' is no stop"
    )
    no_speech: bool = Field(description="nobody spoke: silence, noise, music")
    language: str = Field(max_length=16, description="BCP 47, as the engine read it; empty = it does not say")
    duration_s: float = Field(ge=0.0, description="of the sound")
    took_ms: float = Field(ge=0.0, description="to read it, waiting for others included")
    engine: str = Field(max_length=100, description="who read it, and with which model")


class Hearing(Message):
    """One message of `WS /listen`: the newest reading. The final one is the last message."""

    final: bool
    stop: bool = Field(
        description="an order to stop was heard in this reading or one before it: act at once, without waiting for the "
        "final one; once true it stays true"
    )
    transcript: Transcript


class SpeakRequest(Message):
    text: str = Field(min_length=1, max_length=SPOKEN_CHARACTERS_MAX)
    voice: VoiceName | None = Field(default=None, description="none = the first of `GET /voices`")
    speed: float = Field(default=1.0, ge=0.5, le=2.0, description="1.0 = as the voice speaks by itself")


class Voice(Message):
    name: VoiceName
    engine: str = Field(max_length=32)
    language: str = Field(max_length=16, description="BCP 47; empty = the engine does not say")
