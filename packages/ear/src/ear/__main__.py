"""`python -m ear`, `atom-ear`: the ear and mouth beside the robot, with settings from the environment."""

import asyncio
import contextlib
import signal
import sys
from contextlib import AsyncExitStack
from datetime import datetime
from pathlib import Path

import structlog

from clients.speech import SpeechClient
from ear.adapters.recorded import StandardInput, WavFile
from ear.adapters.services import CoordinatorClient, MemoryClient, RobotClient
from ear.adapters.sound_device import Microphone, NoLoudspeaker, SoundDeviceLoudspeaker
from ear.adapters.wake_word import OpenWakeWordDetector
from ear.ports import Loudspeaker, SoundError, Source
from ear.robot_ear import RobotEar
from ear.settings import MICROPHONE, NONE, STANDARD_INPUT, Settings
from mesh.clock import Clock, SystemClock
from mesh.logging import configure_logging
from mesh.tasks import Tasks, end_this_process

log = structlog.get_logger()


def source_of(settings: Settings, clock: Clock) -> Source:
    if settings.sound == MICROPHONE:
        return Microphone(settings.microphone)
    return StandardInput() if settings.sound == STANDARD_INPUT else WavFile(Path(settings.sound), clock)


def loudspeaker_of(settings: Settings) -> Loudspeaker:
    return NoLoudspeaker() if settings.loudspeaker == NONE else SoundDeviceLoudspeaker(settings.loudspeaker)


async def hear(settings: Settings, *, source: Source | None = None, loudspeaker: Loudspeaker | None = None) -> None:
    """Until the sound ends. Raises `SoundError` where there is none to hear."""
    clock = SystemClock()
    async with AsyncExitStack() as stack:
        speech, robot = SpeechClient(settings), RobotClient(settings)
        coordinator = CoordinatorClient(settings, clock)
        memory = MemoryClient(settings) if settings.memory_url else None
        for one in (speech, robot, coordinator, memory):
            if one is not None:
                stack.push_async_callback(one.aclose)
        tasks = await stack.enter_async_context(Tasks(on_death=end_this_process))
        ear = RobotEar(
            settings=settings,
            clock=clock,
            time_of_day=lambda: datetime.now().astimezone().time(),
            tasks=tasks,
            source=source or source_of(settings, clock),
            loudspeaker=loudspeaker or loudspeaker_of(settings),
            wake_word=OpenWakeWordDetector(settings.wake_word, settings.wake_probability_min),
            speech=speech,
            coordinator=coordinator,
            robot=robot,
            memory=memory,
        )
        log.info("listening", for_=settings.wake_word.value, to=settings.sound)
        await ear.run()


def main() -> None:
    configure_logging("ear")
    settings = Settings.read()
    try:
        asyncio.run(_until_told(settings))
    except SoundError as error:
        sys.exit(str(error))


async def _until_told(settings: Settings) -> None:
    hearing = asyncio.create_task(hear(settings))
    loop = asyncio.get_running_loop()
    for told in (signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(told, hearing.cancel)
    with contextlib.suppress(asyncio.CancelledError):
        await hearing


if __name__ == "__main__":
    main()
