"""Goals from the request to their end: checks, costmaps, a fresh scan, Nav2, progress, and what to tell whom."""

import asyncio
import uuid
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field

import structlog

from contracts.robot import Goal, GoalRequest, GoalStatus, NavigationState, PathReply, PathRequest
from mesh.clock import Clock
from mesh.errors import ConflictError, NotFoundError, UnavailableError, UnprocessableError
from mesh.tasks import Tasks
from robot_bridge.maps import why_not_in
from robot_bridge.navigation import error_name, is_over, moved_on
from robot_bridge.ports import AcceptedGoal, GoalEnd, Robot
from robot_bridge.settings import Settings
from robot_bridge.transforms import compose, inverse
from robot_bridge.wheels import Wheels

log = structlog.get_logger()

GOALS_KEPT = 200
PROGRESS_S = 0.5


@dataclass(slots=True)
class _Active:
    """The one goal that may be under way."""

    goal_id: str
    session_id: str | None
    deadline_s: float
    accepted: AcceptedGoal | None = None
    ending_as: GoalStatus | None = None
    why: str = ""
    over: asyncio.Event = field(default_factory=asyncio.Event)


class Navigator:
    """Lives in asyncio. `publish` hears every change of a goal, and its progress about twice a second."""

    def __init__(
        self,
        *,
        robot: Robot,
        wheels: Wheels,
        clock: Clock,
        tasks: Tasks,
        settings: Settings,
        publish: Callable[[Goal], None],
    ) -> None:
        self._robot = robot
        self._wheels = wheels
        self._clock = clock
        self._tasks = tasks
        self._settings = settings
        self._publish = publish
        self._goals: OrderedDict[str, Goal] = OrderedDict()
        self._active: _Active | None = None
        self._sending = asyncio.Lock()

    @property
    def state(self) -> NavigationState:
        if self._active is not None:
            return NavigationState.NAVIGATING
        missing = self._robot.senses.why_no_nav2(self._clock.now_s())
        return NavigationState.INACTIVE if missing else NavigationState.IDLE

    @property
    def goal_id(self) -> str | None:
        return self._active.goal_id if self._active is not None else None

    def goal(self, goal_id: str) -> Goal:
        if (goal := self._goals.get(goal_id)) is None:
            raise NotFoundError(f"no goal {goal_id[:64]}")
        return goal

    async def send(self, request: GoalRequest) -> Goal:
        """The goal once Nav2 has taken or rejected it. A goal under way is cancelled first: the newest counts."""
        self._check(request)
        async with self._sending:
            await self._end_active("another goal took over")
            if request.clear_costmaps:
                await self._clear_costmaps()
            self._check(request)
            return await self._send(request)

    async def cancel(self, goal_id: str, why: str = "requested") -> Goal:
        """Asks for the end and waits a little for it; the reply tells how far it came."""
        goal = self.goal(goal_id)
        active = self._active
        if active is not None and active.goal_id == goal_id:
            self._end_soon(active, GoalStatus.CANCELED, why)
            try:
                await asyncio.wait_for(active.over.wait(), 2.0)
            except TimeoutError:
                self._finish(active, GoalEnd(GoalStatus.CANCELED, error_msg=f"{why}; Nav2 has not confirmed it"))
            goal = self.goal(goal_id)
        return goal

    def stop(self, why: str) -> None:
        """Ends the goal at once, whatever Nav2 answers (emergency stop, docking)."""
        if (active := self._active) is not None:
            if active.accepted is not None:
                active.accepted.cancel()
            self._finish(active, GoalEnd(GoalStatus.CANCELED, error_msg=why))

    def end_session(self, session_id: str) -> None:
        if (active := self._active) is not None and active.session_id == session_id:
            self.stop("the session ended")

    async def path(self, request: PathRequest) -> PathReply:
        """Nav2's plan, or its error code; nothing moves."""
        self._check_place(request)
        self._need_nav2()
        plan = await self._robot.compute_path(request.goal, request.start)
        if plan.error_code or not plan.poses:
            code = plan.error_code or 208
            return PathReply(reachable=False, error_code=code, error_name=error_name(code))
        steps = [compose(inverse(a), b) for a, b in zip(plan.poses, plan.poses[1:], strict=False)]
        length_m = sum((step.x**2 + step.y**2) ** 0.5 for step in steps)
        return PathReply(reachable=True, length_m=length_m, poses=plan.poses)

    def _check(self, request: GoalRequest) -> None:
        self._wheels.check(request.epoch, request.session_id)
        grid = self._robot.senses.map.value
        if grid is None:
            raise UnavailableError("map", "no map has been received")
        if why := why_not_in(grid, request.pose):
            raise UnprocessableError(why)
        self._need_nav2()

    def _check_place(self, request: PathRequest) -> None:
        grid = self._robot.senses.map.value
        if grid is None:
            raise UnavailableError("map", "no map has been received")
        if why := why_not_in(grid, request.goal):
            raise UnprocessableError(why)

    def _need_nav2(self) -> None:
        if missing := self._robot.senses.why_no_nav2(self._clock.now_s()):
            raise UnavailableError("nav2", missing)

    async def _clear_costmaps(self) -> None:
        """So that ghosts of past obstacles do not reject the goal; then waits for a scan to fill them anew (A13)."""
        try:
            await asyncio.wait_for(self._robot.clear_costmaps(), self._settings.costmap_timeout_s)
        except (UnavailableError, TimeoutError) as error:
            log.warning("the costmaps were not cleared", error=str(error) or type(error).__name__)
        cleared_s = self._clock.now_s()
        await self._robot.senses.scan.wait_for(
            lambda reading: reading.received_s > cleared_s, self._settings.fresh_scan_wait_s_max
        )

    async def _send(self, request: GoalRequest) -> Goal:
        now_s = self._clock.now_s()
        goal = Goal(id=uuid.uuid4().hex, pose=request.pose, status=GoalStatus.PENDING, stamp_s=now_s)
        active = _Active(goal.id, request.session_id, now_s + request.timeout_s)
        self._wheels.open_navigation(goal.id, request.epoch, request.session_id)
        self._active = active
        self._keep(goal)
        try:
            accepted = await self._robot.navigate(request.pose, lambda left_m: self._progress(active, left_m))
        except UnavailableError as error:
            self._finish(active, GoalEnd(GoalStatus.ABORTED, error_msg=error.detail))
            raise
        if accepted is None:
            self._finish(active, GoalEnd(GoalStatus.REJECTED, error_msg="Nav2 rejected the goal"))
            return self._goals[goal.id]
        active.accepted = accepted
        if self._active is not active:  # stopped, or its session ended, while Nav2 was thinking
            accepted.cancel()
            return self._goals[goal.id]
        self._keep(moved_on(self._goals[goal.id], GoalStatus.EXECUTING, stamp_s=self._clock.now_s()))
        self._tasks.start("goal", self._follow(active, accepted), forever=False)
        if active.ending_as is not None:
            accepted.cancel()
        return self._goals[goal.id]

    async def _follow(self, active: _Active, accepted: AcceptedGoal) -> None:
        """Until Nav2 ends it, its time is up, or Nav2 is gone."""
        end = asyncio.ensure_future(accepted.end())
        grace_s: float | None = None
        try:
            while not end.done() and self._active is active:
                await asyncio.wait({end}, timeout=0.25)
                now_s = self._clock.now_s()
                if now_s > active.deadline_s and active.ending_as is None:
                    self._end_soon(active, GoalStatus.TIMED_OUT, "the goal's time is up")
                if active.ending_as is not None and grace_s is None:
                    grace_s = now_s + 2.0
                if missing := self._robot.senses.why_no_nav2(now_s):
                    self._finish(active, GoalEnd(GoalStatus.ABORTED, error_msg=f"Nav2 is gone: {missing}"))
                elif grace_s is not None and now_s > grace_s:
                    self._finish(active, GoalEnd(GoalStatus.CANCELED, error_msg="Nav2 has not confirmed the end"))
            if end.done():
                self._finish(active, end.result())
        finally:
            end.cancel()

    async def _end_active(self, why: str) -> None:
        if (active := self._active) is not None:
            await self.cancel(active.goal_id, why)

    def _end_soon(self, active: _Active, status: GoalStatus, why: str) -> None:
        """Nav2's velocity stops passing now; the goal ends when Nav2 confirms."""
        if active.ending_as is None:
            active.ending_as, active.why = status, why
        self._wheels.close_navigation(active.goal_id)
        if active.accepted is not None:
            active.accepted.cancel()

    def _finish(self, active: _Active, end: GoalEnd) -> None:
        if self._active is not active:
            return
        self._active = None
        self._wheels.close_navigation(active.goal_id)
        status, message = end.status, end.error_msg
        if active.ending_as is not None and status is not GoalStatus.SUCCEEDED:
            status, message = active.ending_as, active.why or message
        goal = self._goals[active.goal_id]
        if not is_over(goal.status):
            now_s = self._clock.now_s()
            self._keep(moved_on(goal, status, stamp_s=now_s, error_code=end.error_code, error_msg=message))
        active.over.set()

    def _progress(self, active: _Active, left_m: float) -> None:
        goal = self._goals.get(active.goal_id)
        now_s = self._clock.now_s()
        if self._active is not active or goal is None or goal.status is not GoalStatus.EXECUTING:
            return
        if goal.distance_remaining_m is None or now_s - goal.stamp_s >= PROGRESS_S:
            self._keep(moved_on(goal, goal.status, stamp_s=now_s, distance_remaining_m=max(0.0, left_m)))

    def _keep(self, goal: Goal) -> None:
        self._goals[goal.id] = goal
        while len(self._goals) > GOALS_KEPT:
            self._goals.popitem(last=False)
        self._publish(goal)


def refuse_while_navigating(navigator: Navigator, what: str) -> None:
    """Raises `ConflictError` where `what` would fight with a goal for the wheels."""
    if navigator.goal_id is not None:
        raise ConflictError(f"{what} has to wait: goal {navigator.goal_id} is under way")
