"""`python -m home_assistant`, `atom-home-assistant`: the robot in Home Assistant, set from the environment."""

import asyncio
import contextlib
import signal
from contextlib import AsyncExitStack

from home_assistant.robot_in_home import RobotInHome
from home_assistant.services import Coordinator, Robot
from home_assistant.settings import Settings
from mesh.clock import SystemClock
from mesh.logging import configure_logging


async def tell(settings: Settings) -> None:
    """Until it is cancelled."""
    async with AsyncExitStack() as stack:
        coordinator, robot = Coordinator(settings), Robot(settings)
        for one in (coordinator, robot):
            stack.push_async_callback(one.aclose)
        await RobotInHome(settings, coordinator=coordinator, robot=robot, clock=SystemClock()).run()


def main() -> None:
    configure_logging("home_assistant")
    asyncio.run(_until_told(Settings.read()))


async def _until_told(settings: Settings) -> None:
    telling = asyncio.create_task(tell(settings))
    loop = asyncio.get_running_loop()
    for told in (signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(told, telling.cancel)
    with contextlib.suppress(asyncio.CancelledError):
        await telling


if __name__ == "__main__":
    main()
