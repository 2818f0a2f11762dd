"""A Wyoming server, by the library's own `AsyncServer`, as a process: `python -m support.wyoming_server PORT [MANNER]`.

It hears how long the sound was and what was to be expected, and speaks a second of a constant. MANNER: `mute` never
answers, `rude` hangs up, `odd` sends a transcript without text.
"""

import asyncio
import sys
from functools import partial

from wyoming.asr import Transcribe, Transcript
from wyoming.audio import AudioChunk, AudioStart, AudioStop
from wyoming.event import Event
from wyoming.info import AsrModel, AsrProgram, Attribution, Describe, Info, TtsProgram, TtsVoice
from wyoming.server import AsyncEventHandler, AsyncServer
from wyoming.tts import Synthesize

NOBODY = Attribution(name="nobody", url="")
ABOUT = {"attribution": NOBODY, "installed": True, "description": "", "version": "1"}
INFO = Info(
    asr=[AsrProgram(name="counter", models=[AsrModel(name="counter", languages=["en"], **ABOUT)], **ABOUT)],
    tts=[TtsProgram(name="constant", voices=[TtsVoice(name="constant", languages=["en"], **ABOUT)], **ABOUT)],
)


class Handler(AsyncEventHandler):
    def __init__(self, manner: str, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        super().__init__(reader, writer)
        self._manner = manner
        self._expected: list[str] = []
        self._bytes = 0

    async def handle_event(self, event: Event) -> bool:
        if Describe.is_type(event.type):
            await self.write_event(INFO.event())
        elif Transcribe.is_type(event.type):
            self._expected = Transcribe.from_event(event).transcript_names or []
        elif AudioChunk.is_type(event.type):
            self._bytes += len(AudioChunk.from_event(event).audio)
        elif AudioStop.is_type(event.type):
            return await self._told()
        elif Synthesize.is_type(event.type):
            form = {"rate": 22_050, "width": 2, "channels": 1}
            await self.write_event(AudioStart(**form).event())
            await self.write_event(AudioChunk(audio=b"\x00\x40" * 22_050, **form).event())
            await self.write_event(AudioStop().event())
        return True

    async def _told(self) -> bool:
        if self._manner == "odd":
            await self.write_event(Event(type="transcript", data={}))
        elif not self._manner:
            text = f"{self._bytes} bytes {' '.join(self._expected)}".strip()
            await self.write_event(Transcript(text=text).event())
        return self._manner != "rude"


def main() -> None:
    manner = sys.argv[2] if len(sys.argv) > 2 else ""
    asyncio.run(AsyncServer.from_uri(f"tcp://127.0.0.1:{sys.argv[1]}").run(partial(Handler, manner)))


if __name__ == "__main__":
    main()
