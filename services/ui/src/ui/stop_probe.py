"""Would a stop reach the robot now? Every open page asks twice a second; the bridge is asked once for all of them."""

import asyncio
from typing import Final

from contracts.robot import EmergencyStop
from mesh.clock import Clock
from mesh.errors import MeshError
from ui.ports import Robot

FRESH_S: Final = 0.2


class StopProbe:
    """Keeps the newest answer of the way a stop takes, for a moment."""

    def __init__(self, robot: Robot, clock: Clock) -> None:
        self._robot = robot
        self._clock = clock
        self._asking = asyncio.Lock()
        self._answer: EmergencyStop | MeshError | None = None
        self._at_s = float("-inf")

    async def ask(self) -> EmergencyStop:
        """What the robot's side says. Raises `MeshError` naming why it says nothing: a stop would not arrive either."""
        async with self._asking:
            answer = self._answer
            if answer is None or self._clock.now_s() - self._at_s > FRESH_S:
                answer = self._answer = await self._ask()
                self._at_s = self._clock.now_s()
        if isinstance(answer, MeshError):
            raise answer
        return answer

    async def _ask(self) -> EmergencyStop | MeshError:
        try:
            return await self._robot.stop_answers()
        except MeshError as error:
            return error
