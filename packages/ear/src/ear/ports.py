"""What the ear needs of the world: sound, a loudspeaker, the wake word, and the services."""

from collections.abc import AsyncIterator, Sequence
from contextlib import AbstractAsyncContextManager
from enum import Enum
from typing import Final, Protocol

from contracts.asking import Answer
from contracts.intent import Understood
from contracts.mission import Heard, Mission, MissionEvent, MissionStatus
from contracts.robot import EmergencyStopReply, EmergencyStopRequest
from contracts.speech import RATE_HZ, Hearing, SpeakRequest, Transcript

CHUNK_S: Final = 0.08
"""What the wake word looks at a time."""
CHUNK_BYTES: Final = int(RATE_HZ * CHUNK_S) * 2


class SoundError(Exception):
    """Why nothing can be heard, or played, here. For a person."""


class Line(Enum):
    """To the timeline. While it is broken nobody knows what happens."""

    OPEN = "open"
    BROKEN = "broken"


class Source(Protocol):
    """Raw 16 kHz 16-bit mono samples, `CHUNK_BYTES` at a time, as they come. Raises `SoundError`."""

    def chunks(self) -> AsyncIterator[bytes]: ...


class Loudspeaker(Protocol):
    async def play(self, wav: bytes) -> None:
        """Until it has ended; a cancelled call ends it. Raises `SoundError`."""
        ...


class WakeWordDetector(Protocol):
    """Blocks; one call at a time."""

    def heard(self, samples: bytes) -> bool:
        """Whether the word ended in these samples, which follow those of the last call."""
        ...

    def forget(self) -> None:
        """What comes next does not follow."""
        ...


class Ears(Protocol):
    """One open line to the speech service."""

    async def send(self, samples: bytes) -> None: ...

    async def end(self) -> None: ...

    def hearings(self) -> AsyncIterator[Hearing]:
        """Until the final one. Raises `UnavailableError`, `UpstreamError`."""
        ...


class Speech(Protocol):
    def listen(self, hot_words: Sequence[str]) -> AbstractAsyncContextManager[Ears]: ...

    async def transcribe(self, samples: bytes) -> Transcript: ...

    async def speak(self, request: SpeakRequest) -> bytes: ...


class Coordinator(Protocol):
    async def understand(self, readings: Sequence[str]) -> Understood: ...

    async def start(self, command: str) -> Mission | Heard: ...

    async def ask(self, question: str) -> Answer: ...

    async def status(self) -> MissionStatus: ...

    async def mission(self, mission_id: str) -> Mission: ...

    async def hold(self, mission_id: str, *, for_s: float) -> Mission:
        """It stands for so long, 0 = it goes on now. Raises `UpstreamError` where a person paused it, or it ended."""
        ...

    def events(self) -> AsyncIterator[MissionEvent | Line]:
        """From now on, for ever: what was missed while the coordinator was away follows, where one event came before.
        Whoever needs to know more asks for the status each time the line opens.
        """
        ...


class Robot(Protocol):
    async def emergency_stop(self, request: EmergencyStopRequest) -> EmergencyStopReply: ...


class Memory(Protocol):
    async def names(self) -> Sequence[str]:
        """Of what it holds, as people say them."""
        ...
