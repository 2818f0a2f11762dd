"""A closed-loop motion as something to wait for."""

import asyncio
from typing import TypeVar

from contracts.motion import MotionEnd
from robot_bridge.motion.motion_executor import ActiveMotion
from robot_bridge.motion.motions import Motion
from robot_bridge.motion.velocity_mux import VelocityMux

R = TypeVar("R")


async def run_motion(wheels: VelocityMux, motion: Motion[R], *, name: str, epoch: int, session_id: str | None) -> R:
    """To its end; ended with the awaiting task. Raises `ConflictError` as `VelocityMux.begin` does."""
    loop = asyncio.get_running_loop()
    reply: asyncio.Future[R] = loop.create_future()

    def settle(value: R) -> None:
        if not reply.done():
            reply.set_result(value)

    def done(value: R) -> None:  # called by the robot's thread
        loop.call_soon_threadsafe(settle, value)

    running = ActiveMotion(motion, name, epoch, session_id, done)
    wheels.begin(running)
    try:
        return await reply
    except asyncio.CancelledError:
        wheels.end_motion(MotionEnd.CLIENT_LEFT, only=running)
        raise
