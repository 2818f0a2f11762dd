"""Would a stop reach the robot now? Every open page asks twice a second; the bridge is asked once for all of them."""

import asyncio
from typing import Final

from mesh.clock import Clock
from mesh.errors import MeshError
from ui.ports import Robot

FRESH_S: Final = 0.2
STATE_WAIT_S: Final = 0.5
"""A page that has no answer for much longer counts STOP as dead (assets/stop.js)."""


class StopProbe:
    """Keeps the newest answer of the way a stop takes, for a moment."""

    def __init__(self, robot: Robot, clock: Clock) -> None:
        self._robot = robot
        self._clock = clock
        self._asking = asyncio.Lock()
        self._answer: bool | MeshError | None = None
        self._at_s = float("-inf")

    async def ask(self) -> bool | None:
        """Whether the robot is stopped; None if the bridge lets only a stop in, as with a page's key that is revoked.

        Raises `MeshError` naming why a stop would not arrive.
        """
        async with self._asking:
            answer = self._answer
            if self._clock.now_s() - self._at_s > FRESH_S:
                answer = self._answer = await self._ask()
                self._at_s = self._clock.now_s()
        if isinstance(answer, MeshError):
            raise answer
        return answer

    async def _ask(self) -> bool | MeshError | None:
        try:
            await self._robot.stop_answers()
        except MeshError as error:
            return error
        try:
            async with asyncio.timeout(STATE_WAIT_S):
                return (await self._robot.stop_state()).latched
        except (MeshError, TimeoutError):
            return None
