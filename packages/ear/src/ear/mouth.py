"""The loudspeaker, with a limit to everything it plays, and the tones one after another."""

import asyncio
from dataclasses import dataclass, field
from typing import Final

import structlog

from ear.deadlines import length_s, within
from ear.messages import Tone
from ear.ports import Loudspeaker, SoundError
from ear.tones import wav_of
from mesh.clock import Clock

log = structlog.get_logger()

LATE_S: Final = 5.0
"""Longer than it lasts: a device opens, and what it still holds is played out."""


@dataclass
class Mouth:
    loudspeaker: Loudspeaker
    clock: Clock
    _tones: asyncio.Queue[Tone] = field(default_factory=asyncio.Queue[Tone])

    async def play(self, wav: bytes) -> None:
        """Until it has ended. Raises `SoundError`, also `LATE_S` after it should have."""
        try:
            await within(self.clock, length_s(wav) + LATE_S, self.loudspeaker.play(wav))
        except TimeoutError:
            raise SoundError("the loudspeaker does not come to an end") from None

    def sound(self, tone: Tone) -> None:
        self._tones.put_nowait(tone)

    async def play_tones(self) -> None:
        while True:
            tone = await self._tones.get()
            try:
                await self.play(wav_of(tone))
            except SoundError as error:
                log.warning("no tone", why=str(error))
