"""Driving by hand: the browser's stick in, leases on the wheels out, and what became of them back."""

import structlog
from fastapi import APIRouter, WebSocket, WebSocketDisconnect
from pydantic import Field, ValidationError

from contracts.base import Message
from contracts.geometry import Twist2D
from contracts.robot import Priority, VelocityRequest
from mesh.access import Role, requires_role
from mesh.errors import MeshError
from ui.desk import Desk
from ui.i18n import _
from ui.operator_actions import in_words, why_not_by_hand
from ui.ports import Wheels
from ui.routes.deps import desk_of
from ui.teleoperation import Delay, Stick, twist

router = APIRouter()
log = structlog.get_logger()

SOURCE = "teleop"


class Driven(Message):
    """What became of a word of the stick."""

    ok: bool
    text: str = ""
    linear_x: float = Field(default=0.0, description="m/s sent to the wheels")
    angular_z: float = Field(default=0.0, description="rad/s sent to the wheels")


@router.websocket("/teleop")
@requires_role(Role.OPERATOR)
async def teleop(socket: WebSocket) -> None:
    """Stick in, Driven out, each as JSON. Closed with 1013 while another page drives; the lease ends with it."""
    desk = desk_of(socket)
    await socket.accept()
    if desk.driver is not None:
        await socket.close(1013, _("Another page is driving."))
        return
    desk.driver = socket
    try:
        async with desk.robot.wheels() as wheels:
            await _drive(socket, desk, wheels)
    except MeshError as error:
        await socket.close(1011, in_words(error)[:100])
    except (WebSocketDisconnect, KeyError, RuntimeError):  # KeyError: binary in; RuntimeError: it closed under a send
        pass
    finally:
        desk.driver = None


async def _drive(socket: WebSocket, desk: Desk, wheels: Wheels) -> None:
    hold, delay = Hold(desk, wheels), Delay()
    while True:
        text = await socket.receive_text()
        try:
            stick = Stick.model_validate_json(text)
        except ValidationError:
            driven = Driven(ok=False, text="malformed")
        else:
            driven = await hold.move(stick, delay.of(stick.t_ms, desk.clock.now_s()))
        await socket.send_text(driven.model_dump_json())


class Hold:
    """One holding of the stick: begun while motion is permitted, over for good once it was refused."""

    def __init__(self, desk: Desk, wheels: Wheels) -> None:
        self._desk = desk
        self._wheels = wheels
        self._epoch: int | None = None
        self._refused = ""

    async def move(self, stick: Stick, delay_s: float) -> Driven:
        settings = self._desk.settings
        if stick.let_go:
            self._refused = ""
            if self._epoch is None:
                return Driven(ok=True)
            epoch, self._epoch = self._epoch, None
            return await self._send(Twist2D(), epoch)
        if self._refused:
            return Driven(ok=False, text=self._refused)
        if delay_s > settings.teleop_delay_s_max:
            return Driven(ok=False, text=_("The connection is too slow to drive by hand."))
        self._refused, body = why_not_by_hand(self._desk), self._desk.facts.body
        if self._refused or body is None:
            return Driven(ok=False, text=self._refused)
        if self._epoch is None:
            self._epoch = (await self._desk.robot.stop_state()).epoch
        wanted = twist(
            stick,
            speed_m_s=settings.teleop_speed_share * body.speed_m_s_max,
            turn_rad_s=settings.teleop_turn_share * body.turn_rad_s_max,
        )
        return await self._send(wanted, self._epoch)

    async def _send(self, wanted: Twist2D, epoch: int) -> Driven:
        reply = await self._wheels.send(
            VelocityRequest(
                twist=wanted,
                source=SOURCE,
                priority=Priority.MANUAL,
                duration_s=self._desk.settings.teleop_lease_s,
                epoch=epoch,
                allow_reverse=True,
            )
        )
        if not reply.accepted:
            self._refused = reply.reason or _("refused")
        return Driven(
            ok=reply.accepted, text=reply.reason, linear_x=reply.sent.linear_x, angular_z=reply.sent.angular_z
        )
