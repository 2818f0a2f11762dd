"""What the operator does: commands passed on, each answered in words for a person."""

import asyncio
import functools
import math
import uuid
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Concatenate, Final, ParamSpec

import structlog

from contracts.access import Principal, Role
from contracts.asking import Answer
from contracts.geometry import Pose2D
from contracts.mission import Heard
from contracts.motion import BaseReply, RotateReply, RotateRequest
from contracts.reading import Mood
from contracts.robot import CandidatePose, EmergencyStopReply, EmergencyStopRequest, Goal, GoalRequest, GoalStatus
from mesh.errors import ConflictError, MeshError, UpstreamError
from mesh.tracing import Tracer
from ui.desk import Desk
from ui.i18n import _
from vocabulary.orders import order_in

log = structlog.get_logger()

TRACER: Final = Tracer(__name__)

COMMAND_MAX: Final = 500
OBEYED_S: Final = 1.5
"""So long the coordinator may take to say that a typed stop was obeyed."""


@dataclass(frozen=True, slots=True)
class ActionResult:
    """What came of an action, in words for a person."""

    ok: bool
    text: str


A = ParamSpec("A")


def for_role(
    role: Role,
) -> Callable[
    [Callable[Concatenate["OperatorActions", A], Awaitable[ActionResult]]],
    Callable[Concatenate["OperatorActions", A], Awaitable[ActionResult]],
]:
    """Refused to whom has not the role, or no more: a page stays open longer than a key may last."""

    def declared(
        act: Callable[Concatenate["OperatorActions", A], Awaitable[ActionResult]],
    ) -> Callable[Concatenate["OperatorActions", A], Awaitable[ActionResult]]:
        @functools.wraps(act)
        async def permitted(self: "OperatorActions", *args: A.args, **kwargs: A.kwargs) -> ActionResult:
            return refused if (refused := self.refused(role)) is not None else await act(self, *args, **kwargs)

        return permitted

    return declared


class OperatorActions:
    """Stateless but for the desk: every act names what it acts on. What the page asks other services, it asks with its
    own key; so each act but a stop says here who may."""

    def __init__(self, desk: Desk, asks: Callable[[], Principal | None]) -> None:
        """`asks` tells who it is now (`mesh.access.who_now`)."""
        self._desk = desk
        self._asks = asks

    def refused(self, role: Role) -> ActionResult | None:
        principal = self._asks()
        if principal is None:
            return ActionResult(False, _("You are not logged in any more."))
        if not principal.role.may(role):
            return ActionResult(
                False, _("This needs the role {role}; yours is {yours}.", role=role, yours=principal.role)
            )
        return None

    # stopping

    async def emergency_stop(self, *, reason: str, by: str) -> EmergencyStopReply:
        """Straight to robot_bridge; needs neither Redis nor any other service."""
        desk = self._desk
        reply = await desk.robot.emergency_stop(EmergencyStopRequest(reason=reason, by=by))
        desk.facts.take_stop_reply(reply, desk.clock.now_s())
        log.warning("emergency stop", reason=reason, by=by, first_zero_ms=reply.first_zero_ms)
        return reply

    @for_role(Role.OPERATOR)
    async def reset(self, *, by: str) -> ActionResult:
        async def do() -> str:
            desk = self._desk
            reply = await desk.robot.reset(EmergencyStopRequest(reason="RESUME confirmed on the page", by=by))
            desk.facts.take_stop_reply(reply, desk.clock.now_s())
            return _("The robot may move again. It waits for your next command.")

        return await result_of(do())

    # missions

    async def command(self, text: str) -> ActionResult:
        words = text.strip()
        if not words:
            return ActionResult(False, _("Say what to find, for example: find the red bottle"))
        if len(words) > COMMAND_MAX:
            return ActionResult(False, _("That is {n} characters; {max} is the limit.", n=len(words), max=COMMAND_MAX))

        order = order_in(words)
        if order is not None and order.mood is not Mood.RESUME:
            return await self._obey(words, order.mood)
        if (refused := self.refused(Role.OPERATOR)) is not None:
            return refused

        async def do() -> str:
            with TRACER.command("typed", {"command": words}):
                mission = await self._desk.missions.start(words, key=uuid.uuid4().hex)
            if isinstance(mission, Heard):
                return mission.text
            what = mission.target.description if mission.target is not None else mission.command
            if mission.queue_position is not None:
                return _("Queued: {what}", what=what)
            return _("Looking for: {what}", what=what)

        return await result_of(do())

    async def _obey(self, words: str, mood: Mood) -> ActionResult:
        """A typed stop. Where the coordinator does not confirm it soon, it becomes the emergency stop."""
        if mood is not Mood.EMERGENCY:
            try:
                async with asyncio.timeout(OBEYED_S):
                    heard = await self._desk.missions.start(words, key=uuid.uuid4().hex)
                if not isinstance(heard, Heard) or heard.still or mood is Mood.PAUSE:
                    return ActionResult(
                        True, heard.text if isinstance(heard, Heard) else _("Looking for: {what}", what=words)
                    )
            except (MeshError, TimeoutError) as error:
                log.warning("a typed stop was not confirmed: the emergency stop instead", error=str(error))

        async def do() -> str:
            await self.emergency_stop(reason=f"typed: {words[:100]}", by="page")
            return _("Emergency stop.")

        return await result_of(do())

    async def ask(self, text: str) -> Answer | ActionResult:
        words = text.strip()
        if not words or len(words) > COMMAND_MAX:
            return ActionResult(False, _("Ask something, for example: where did you last see my keys?"))
        if order_in(words) is not None:
            return await self.command(words)
        try:
            return await self._desk.missions.ask(words)
        except MeshError as error:
            return ActionResult(False, in_words(error))

    @for_role(Role.OPERATOR)
    async def pause(self) -> ActionResult:
        return await self._with_mission(self._desk.missions.pause, _("Paused."))

    @for_role(Role.OPERATOR)
    async def resume(self) -> ActionResult:
        return await self._with_mission(self._desk.missions.resume, _("Mission continued."))

    @for_role(Role.OPERATOR)
    async def cancel(self) -> ActionResult:
        return await self._with_mission(self._desk.missions.cancel, _("Cancelled."))

    @for_role(Role.OPERATOR)
    async def take_from_queue(self, mission_id: str) -> ActionResult:
        async def do() -> str:
            await self._desk.missions.cancel(mission_id)
            return _("Removed from the queue.")

        return await result_of(do())

    # driving there

    @for_role(Role.OPERATOR)
    async def go(self, x: float, y: float) -> ActionResult:
        """Drives to a place of the map (m), facing the way it came to it."""

        async def do() -> str:
            pose = self._free_to_move()
            yaw = math.atan2(y - pose.y, x - pose.x)
            desk = self._desk
            epoch = (await desk.robot.stop_state()).epoch
            goal = await desk.robot.go(
                GoalRequest(
                    candidates=(CandidatePose(pose=Pose2D(x=x, y=y, yaw=yaw)),),
                    epoch=epoch,
                    timeout_s=desk.settings.goal_timeout_s,
                )
            )
            if goal.status in {GoalStatus.REJECTED, GoalStatus.ABORTED}:
                raise UpstreamError("robot_bridge", 200, goal_end_in_words(goal))
            desk.facts.take_goal(goal)
            return _("Driving there.")

        return await result_of(do())

    @for_role(Role.OPERATOR)
    async def look(self, x: float, y: float) -> ActionResult:
        """Turns until the camera looks at a place of the map (m)."""

        async def do() -> str:
            pose = self._free_to_move()
            angle_rad = math.remainder(math.atan2(y - pose.y, x - pose.x) - pose.yaw, math.tau)
            epoch = (await self._desk.robot.stop_state()).epoch
            moving = self._desk.robot.rotate(RotateRequest(angle_rad=angle_rad, speed_rad_s=1.0, epoch=epoch))
            return await moved(moving, _("Turned to look there."), _("It did not turn"))

        return await result_of(do())

    @for_role(Role.OPERATOR)
    async def halt(self) -> ActionResult:
        """Ends the drive or turn asked for by hand; refused while a mission drives, whose goal it would end."""

        async def do() -> str:
            if mission_drives(self._desk):
                raise ConflictError(_("A mission is running. Pause it first."))
            goal = self._desk.facts.goal
            if goal is not None:
                await self._desk.robot.cancel_goal(goal.id)
            await self._desk.robot.end_motion()
            return _("Drive cancelled.")

        return await result_of(do())

    def _free_to_move(self) -> Pose2D:
        """Where the robot stands. Raises `ConflictError` while a mission drives, or nobody knows where it is."""
        desk = self._desk
        why = why_not_by_hand(desk)
        if why:
            raise ConflictError(why)
        robot = desk.facts.robot
        if robot is None or robot.pose is None or desk.clock.now_s() - desk.facts.robot_at_s > 5.0:
            raise ConflictError(_("The robot's position is unknown."))
        return robot.pose

    # the base

    @for_role(Role.OPERATOR)
    async def dock(self) -> ActionResult:
        return await result_of(moved(self._desk.robot.dock(), _("On the dock."), _("It did not dock")))

    @for_role(Role.OPERATOR)
    async def undock(self) -> ActionResult:
        return await result_of(moved(self._desk.robot.undock(), _("Off the dock."), _("It did not undock")))

    @for_role(Role.OPERATOR)
    async def celebrate(self) -> ActionResult:
        return await result_of(moved(self._desk.robot.celebrate(), _("Celebrating."), _("It did not celebrate")))

    # memory

    @for_role(Role.OPERATOR)
    async def forget_object(self, object_id: int) -> ActionResult:
        return await self._forget(self._desk.memory.forget_object(object_id))

    @for_role(Role.OPERATOR)
    async def forget_label(self, label: str) -> ActionResult:
        return await self._forget(self._desk.memory.forget_label(label))

    @for_role(Role.OPERATOR)
    async def name_room(self, room_id: int, name: str) -> ActionResult:
        async def do() -> str:
            named = await self._desk.memory.name_room(room_id, name)
            await self._desk.refresh_rooms(now=True)
            return _("It is called {name} now.", name=named.name)

        return await result_of(do())

    async def _forget(self, forgetting: Awaitable[int]) -> ActionResult:
        async def do() -> str:
            deleted = await forgetting
            await self._desk.refresh_memory(now=True)
            return _("{n} records deleted.", n=deleted)

        return await result_of(do())

    @for_role(Role.ADMIN)
    async def import_memory(self, data: bytes) -> ActionResult:
        async def do() -> str:
            reply = await self._desk.memory.import_(data)
            await self._desk.refresh_memory(now=True)
            return _("Imported: {objects} objects, {views} views.", objects=reply.objects, views=reply.views)

        return await result_of(do())

    async def _with_mission(self, act: Callable[[str], Awaitable[object]], done: str) -> ActionResult:
        mission_id = self._desk.facts.mission_id
        if mission_id is None:
            return ActionResult(False, _("There is no mission."))

        async def do() -> str:
            await act(mission_id)
            return done

        return await result_of(do())


def why_not_by_hand(desk: Desk) -> str:
    """'' when nothing else is about to move the robot."""
    if desk.facts.stop is not None and desk.facts.stop.latched:
        return _("The robot is stopped. Resume first.")
    if desk.facts.body is None:
        return _("The robot has not said yet how fast it can drive.")
    return _("A mission is running. Pause it first.") if mission_drives(desk) else ""


def mission_drives(desk: Desk) -> bool:
    status = desk.facts.mission
    mission = status.mission if status is not None else None
    return mission is not None and mission.outcome is None and not mission.paused and mission.queue_position is None


async def moved(motion: Awaitable[BaseReply | RotateReply], done: str, failed: str) -> str:
    reply = await motion
    if not reply.end.completed:
        raise UpstreamError("robot_bridge", 200, f"{failed}: {reply.text or _('no reason given')}")
    return done


async def result_of(doing: Awaitable[str]) -> ActionResult:
    try:
        return ActionResult(True, await doing)
    except MeshError as error:
        return ActionResult(False, in_words(error))


def in_words(error: MeshError) -> str:
    """A refusal in the words of the service; one that is away is named."""
    return error.said if isinstance(error, UpstreamError) else error.detail


def goal_end_in_words(goal: Goal) -> str:
    """Why a goal came to nothing: the bridge's words, else what its type says; no reason is made up."""
    if goal.error_msg:
        return goal.error_msg
    return goal.cause.sentence if goal.cause is not None else _("no reason given")
