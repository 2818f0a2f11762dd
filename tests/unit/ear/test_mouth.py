"""A loudspeaker that does not come to an end, and one that cannot even be told to: neither keeps the ear."""

import asyncio
import io
import wave

import pytest

from ear.adapters.sound_device import SoundDeviceLoudspeaker
from ear.deadlines import length_s, within
from ear.messages import Tone
from ear.mouth import LATE_S, Mouth
from ear.ports import SoundError
from ear.tones import NOTE_S, wav_of
from mesh.tasks import Tasks
from support.ear_fakes import FakeLoudspeaker
from support.fake_clock import FakeClock


def wav(seconds: float) -> bytes:
    file = io.BytesIO()
    with wave.open(file, "wb") as out:
        out.setnchannels(1)
        out.setsampwidth(2)
        out.setframerate(16_000)
        out.writeframes(bytes(round(2 * 16_000 * seconds)))
    return file.getvalue()


class StubbornLoudspeaker(FakeLoudspeaker):
    """A driver that hangs: it takes no notice of being told to stop."""

    async def play(self, wav: bytes) -> None:
        self.played.append(wav)
        while not self.quiet.is_set():
            try:
                await self.quiet.wait()
            except asyncio.CancelledError:
                continue


@pytest.mark.parametrize("loudspeaker", [FakeLoudspeaker(), StubbornLoudspeaker()], ids=["hangs", "stubborn"])
async def test_what_does_not_come_to_an_end_is_left(loudspeaker: FakeLoudspeaker) -> None:
    clock = FakeClock()
    loudspeaker.waits = True
    playing = asyncio.create_task(Mouth(loudspeaker, clock).play(wav(2.0)))
    await clock.advance(2.0 + LATE_S - 0.1)
    assert not playing.done()
    await clock.advance(0.2)
    with pytest.raises(SoundError, match="does not come to an end"):
        await playing
    loudspeaker.quiet.set()
    await clock.settle()


async def test_a_tone_that_hangs_is_followed_by_the_next() -> None:
    clock, loudspeaker = FakeClock(), FakeLoudspeaker()
    loudspeaker.waits = True
    mouth = Mouth(loudspeaker, clock)
    async with Tasks() as tasks:
        tasks.start("tones", mouth.play_tones())
        mouth.sound(Tone.AWAKE)
        mouth.sound(Tone.TROUBLE)
        await clock.advance(LATE_S + 1.0)
        assert loudspeaker.played == [wav_of(Tone.AWAKE), wav_of(Tone.TROUBLE)]


async def test_what_is_done_in_time_gives_what_it_gives_and_fails_as_it_fails() -> None:
    clock = FakeClock()

    async def gives() -> int:
        return 3

    async def fails() -> int:
        raise SoundError("no device")

    assert await within(clock, 1.0, gives()) == 3
    with pytest.raises(SoundError, match="no device"):
        await within(clock, 1.0, fails())


async def test_who_is_told_to_stop_waiting_tells_the_work_so() -> None:
    clock, loudspeaker, ended = FakeClock(), FakeLoudspeaker(), asyncio.Event()

    async def plays() -> None:
        try:
            await loudspeaker.quiet.wait()
        finally:
            ended.set()

    waiting = asyncio.create_task(within(clock, 1.0, plays()))
    await clock.settle()
    waiting.cancel()
    with pytest.raises(asyncio.CancelledError):
        await waiting
    await clock.settle()
    assert ended.is_set()


async def test_the_loudspeaker_refuses_what_is_no_wav() -> None:
    for wrong in (b"", b"no WAV", b"RIFF"):
        with pytest.raises(SoundError, match="no WAV"):
            await SoundDeviceLoudspeaker().play(wrong)


def test_a_wav_tells_how_long_it_lasts_and_what_is_none_lasts_no_time() -> None:
    assert length_s(wav(1.5)) == pytest.approx(1.5)
    assert length_s(wav_of(Tone.AWAKE)) == pytest.approx(2 * NOTE_S, abs=0.01)
    assert length_s(b"no WAV") == length_s(b"") == 0.0
