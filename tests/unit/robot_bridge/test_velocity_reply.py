"""Which tick the reply to a velocity tells of."""

import asyncio
from types import SimpleNamespace

from contracts.geometry import Twist2D
from contracts.robot import VelocityRequest
from mesh.latest_value import LatestValue
from robot_bridge.motion.arbiter import NO_COMMAND, ArbitratedCommand, Request
from robot_bridge.routes.velocity import velocity

ASKED = Twist2D(linear_x=0.2)


async def test_it_tells_of_a_tick_that_knew_of_the_lease_not_of_one_just_before_it() -> None:
    commanded: LatestValue[ArbitratedCommand] = LatestValue()
    clock = SimpleNamespace(s=10.0, now_s=lambda: clock.s)

    def request(_: Request) -> None:
        commanded.put(NO_COMMAND, 10.01)  # the robot's thread ticks while the request still waits for its turn
        clock.s = 10.02

    bridge = SimpleNamespace(wheels=SimpleNamespace(request=request, commanded=commanded), clock=clock)
    asking = asyncio.create_task(velocity(VelocityRequest(twist=ASKED, source="test", epoch=0), bridge))
    await asyncio.sleep(0)
    commanded.put(ArbitratedCommand(ASKED, "test", ASKED), 10.06)
    reply = await asking
    assert (reply.sent, reply.source, reply.causes, reply.reason) == (ASKED, "test", (), "")
