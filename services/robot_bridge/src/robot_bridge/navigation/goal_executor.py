"""Goals from the request to their end: checks, preflight, Nav2, progress, another try, and what to tell whom."""

import asyncio
import uuid
from collections.abc import Awaitable, Callable

import structlog

from contracts.causes import GoalCause, Refusal
from contracts.geometry import Pose2D
from contracts.robot import Goal, GoalMode, GoalRequest, GoalStatus, NavigationState, PathReply, PathRequest, Sighting
from contracts.vision import ObjectSpotted
from mesh.clock import Clock
from mesh.errors import ConflictError, UnavailableError
from mesh.tasks import Tasks
from robot_bridge.motion.velocity_mux import VelocityMux
from robot_bridge.navigation import maps
from robot_bridge.navigation.goal_states import (
    cause_of,
    error_name,
    is_over,
    with_status,
    worth_another_try,
)
from robot_bridge.navigation.goal_store import ActiveGoal, GoalStore
from robot_bridge.navigation.path_check import GoalRegion, PathCheck, PathChecker, path_or_none, path_reply
from robot_bridge.ports import GoalEnd, Robot
from robot_bridge.settings import Settings

log = structlog.get_logger()

CANCEL_S_MAX = 2.0

Measure = Callable[[ObjectSpotted], Awaitable[Sighting]]


class GoalExecutor:
    """Lives in asyncio. At most one goal is under way. `publish` hears of each as `GoalStore` tells."""

    def __init__(
        self,
        *,
        robot: Robot,
        wheels: VelocityMux,
        clock: Clock,
        tasks: Tasks,
        settings: Settings,
        publish: Callable[[Goal], None],
        measure: Measure,
    ) -> None:
        self._robot = robot
        self._wheels = wheels
        self._clock = clock
        self._tasks = tasks
        self._settings = settings
        self._measure = measure
        self._preflight = PathChecker(robot, settings)
        self._goals = GoalStore(publish)
        self._active: ActiveGoal | None = None
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
        return self._goals.get(goal_id)

    async def send(self, request: GoalRequest) -> Goal:
        """The goal once Nav2 has taken or rejected it, or no path leads there (ABORTED).

        A goal under way is cancelled first: the newest counts.
        """
        self._check(request)
        async with self._sending:
            await self._need_nav2(self._settings.nav2_active_wait_s)
            await self._end_active(GoalCause.PREEMPTED)
            if request.clear_costmaps:
                await self._preflight.clear_costmaps(self._clock)
            place = self._place(request.pose, request)
            checked = await path_or_none(self._preflight, place)
            self._check(request)
            return await self._begin(request, place, checked)

    async def cancel(self, goal_id: str, cause: GoalCause = GoalCause.CANCELED) -> Goal:
        """Asks for the end and waits a little for it; the reply tells how far it came."""
        goal = self.goal(goal_id)
        active = self._active
        if active is not None and active.goal_id == goal_id:
            self._end_soon(active, GoalStatus.CANCELED, cause)
            try:
                await asyncio.wait_for(active.over.wait(), CANCEL_S_MAX)
            except TimeoutError:
                self._finish(active, GoalEnd(GoalStatus.CANCELED), cause)
            goal = self.goal(goal_id)
        return goal

    async def over(self, goal_id: str) -> Goal:
        """The goal at its end, however long that takes."""
        if (active := self._active) is not None and active.goal_id == goal_id:
            await active.over.wait()
        return self.goal(goal_id)

    def stop(self, cause: GoalCause) -> None:
        """Ends the goal at once, whatever Nav2 answers (emergency stop, docking)."""
        if (active := self._active) is not None:
            if active.accepted is not None:
                active.accepted.cancel()
            self._finish(active, GoalEnd(GoalStatus.CANCELED), cause)

    def end_session(self, session_id: str) -> None:
        if (active := self._active) is not None and active.session_id == session_id:
            self.stop(GoalCause.SESSION_ENDED)

    async def on_object_spotted(self, spotted: ObjectSpotted) -> None:
        """The target was seen: ends an exploration's goal, measures for an approach (requirement A13)."""
        active = self._active
        if active is None or active.mode is GoalMode.PLAIN or active.ending_as is not None:
            return
        if spotted.stamp_s <= active.seen_from_s:
            return
        if active.mode is GoalMode.EXPLORATION:
            self._end_soon(active, GoalStatus.CANCELED, GoalCause.SIGHTED, f"{spotted.target.description} was sighted")
        sighting = await self._measure(spotted)
        goal = self._goals.get(active.goal_id)
        self._goals.keep(goal.model_copy(update={"sighting": sighting, "stamp_s": self._clock.now_s()}))

    async def path(self, request: PathRequest) -> PathReply:
        """Nav2's plan to the pose or the nearest one on the ring, or its error code; nothing moves."""
        maps.check_in_map(maps.known(self._robot.senses), request.goal)
        await self._need_nav2(0.0)
        checked = await self._preflight.nearest(self._place(request.goal, request), request.start)
        return path_reply(checked)

    def _place(self, pose: Pose2D, request: GoalRequest | PathRequest) -> GoalRegion:
        radius_m = self._settings.ring_radius_m if request.ring_radius_m is None else request.ring_radius_m
        return GoalRegion(pose, radius_m, request.look_at)

    def _check(self, request: GoalRequest) -> None:
        self._wheels.check(request.epoch, request.session_id)
        maps.check_in_map(maps.known(self._robot.senses), request.pose)

    async def _need_nav2(self, wait_s: float) -> None:
        """Its lifecycle has to be active; it may be about to become so."""
        senses = self._robot.senses
        await senses.nav2_missing.wait_for(lambda _: not senses.why_no_nav2(self._clock.now_s()), wait_s)
        if missing := senses.why_no_nav2(self._clock.now_s()):
            raise UnavailableError("nav2", missing, code=Refusal.NO_NAV2)

    async def _begin(self, request: GoalRequest, place: GoalRegion, checked: PathCheck | None) -> Goal:
        now_s = self._clock.now_s()
        pose = checked.pose if checked is not None and checked.pose is not None else request.pose
        goal = Goal(
            id=uuid.uuid4().hex,
            pose=pose,
            wanted=request.pose,
            mode=request.mode,
            status=GoalStatus.PENDING,
            stamp_s=now_s,
        )
        picture = self._robot.senses.rgb.value
        active = ActiveGoal(
            goal.id,
            place,
            request.mode,
            request.session_id,
            now_s + request.timeout_s,
            picture.stamp_s if picture is not None else 0.0,
        )
        self._wheels.open_navigation(goal.id, request.epoch, request.session_id)
        self._wheels.hold_navigation(goal.id)
        self._active = active
        self._goals.keep(goal)
        if checked is not None and checked.unreachable:
            self._finish(active, GoalEnd(GoalStatus.ABORTED, checked.error_code, checked.reason), GoalCause.UNREACHABLE)
            return self._goals.get(goal.id)
        try:
            await self._ask_nav2(active, pose)
        except UnavailableError as error:
            self._finish(active, GoalEnd(GoalStatus.ABORTED, error_msg=error.detail), GoalCause.NAV2_GONE)
            raise
        except asyncio.CancelledError:  # an answer that comes now is nobody's goal: the adapter cancels it
            self._finish(active, GoalEnd(GoalStatus.CANCELED), GoalCause.CLIENT_LEFT)
            raise
        if active.accepted is not None and self._active is active:
            self._goals.keep(with_status(self._goals.get(goal.id), GoalStatus.EXECUTING, stamp_s=self._clock.now_s()))
            self._tasks.start("goal", self._follow(active), forever=False)
        return self._goals.get(goal.id)

    async def _ask_nav2(self, active: ActiveGoal, pose: Pose2D) -> None:
        """Nav2 takes the goal (`active.accepted`) or rejects it, which ends it."""
        active.accepted = await self._robot.navigate(pose, lambda left_m: self._progress(active, left_m))
        if active.accepted is None:
            first = self._goals.get(active.goal_id).status is GoalStatus.PENDING
            rejected = GoalStatus.REJECTED if first else GoalStatus.ABORTED
            self._finish(active, GoalEnd(rejected), GoalCause.REJECTED)
        elif self._active is not active or active.ending_as is not None:
            active.accepted.cancel()  # stopped, or its session ended, while Nav2 was thinking
        else:
            self._wheels.release_navigation(active.goal_id)

    async def _follow(self, active: ActiveGoal) -> None:
        """Until Nav2 ends it, its time is up, or Nav2 is gone; tries again where Nav2 gave up under way."""
        for attempt in range(1, self._settings.retries_max + 2):
            end = await self._until_end(active)
            if end is None:
                return
            self._wheels.hold_navigation(active.goal_id)  # its controller may drive on without a goal
            cause = await self._cause(active, end)
            last = attempt > self._settings.retries_max or active.ending_as is not None
            if last or cause is GoalCause.FOREIGN_GOAL or not worth_another_try(end):
                self._finish(active, end, cause)
                return
            try:
                await self._try_again(active, end, attempt + 1)
            except UnavailableError as error:
                gone = GoalEnd(GoalStatus.ABORTED, end.error_code, f"{end.error_msg}; {error.detail}")
                self._finish(active, gone, GoalCause.NAV2_GONE)

    async def _cause(self, active: ActiveGoal, end: GoalEnd) -> GoalCause:
        cause, accepted = cause_of(end), active.accepted
        if cause is GoalCause.NAV2_SILENT and accepted is not None and await accepted.was_preempted():
            return GoalCause.FOREIGN_GOAL
        return cause

    async def _try_again(self, active: ActiveGoal, end: GoalEnd, attempt: int) -> None:
        """From where the robot stands, costmaps cleared; from the third time on to a roomier pose on the ring."""
        goal, name = self._goals.get(active.goal_id), error_name(end.error_code)
        log.info("Nav2 gave up under way; trying again", goal=goal.id, error=name, attempt=attempt)
        why = end.error_msg or name or cause_of(end).sentence
        told = {"attempt": attempt, "error_code": end.error_code, "error_name": name, "error_msg": why}
        active.accepted = None
        self._goals.keep(goal.model_copy(update=told | {"stamp_s": self._clock.now_s()}))
        await self._preflight.clear_costmaps(self._clock)
        roomier = (await self._preflight.roomier(active.place, goal.pose)).pose if attempt > 2 else None
        if self._active is not active:
            return
        if active.ending_as is not None:
            self._finish(active, end)
            return
        if roomier is not None:
            self._goals.keep(self._goals.get(goal.id).model_copy(update={"pose": roomier}))
        await self._ask_nav2(active, roomier or goal.pose)

    async def _until_end(self, active: ActiveGoal) -> GoalEnd | None:
        """How Nav2 ended it; none when it is over already."""
        if active.accepted is None:
            return None
        end = asyncio.ensure_future(active.accepted.end())
        grace_s: float | None = None
        try:
            while not end.done() and self._active is active:
                await asyncio.wait({end}, timeout=0.25)
                now_s = self._clock.now_s()
                if now_s > active.deadline_s and active.ending_as is None:
                    self._end_soon(active, GoalStatus.TIMED_OUT, GoalCause.TIMED_OUT)
                if active.ending_as is not None and grace_s is None:
                    grace_s = now_s + CANCEL_S_MAX
                if missing := self._robot.senses.why_no_nav2(now_s):
                    gone = GoalEnd(GoalStatus.ABORTED, error_msg=f"Nav2 is gone: {missing}")
                    self._finish(active, gone, GoalCause.NAV2_GONE)
                elif grace_s is not None and now_s > grace_s:
                    self._finish(active, GoalEnd(GoalStatus.CANCELED), active.cause)
            return end.result() if end.done() and self._active is active else None
        finally:
            end.cancel()

    async def _end_active(self, cause: GoalCause) -> None:
        if (active := self._active) is not None:
            await self.cancel(active.goal_id, cause)

    def _end_soon(self, active: ActiveGoal, status: GoalStatus, cause: GoalCause, why: str = "") -> None:
        """Nav2's velocity stops passing now; the goal ends when Nav2 confirms."""
        if active.ending_as is None:
            active.ending_as, active.cause, active.why = status, cause, why
        self._wheels.close_navigation(active.goal_id)
        if active.accepted is not None:
            active.accepted.cancel()

    def _finish(self, active: ActiveGoal, end: GoalEnd, cause: GoalCause | None = GoalCause.NAV2) -> None:
        if self._active is not active:
            return
        self._active = None
        self._wheels.close_navigation(active.goal_id)
        status, message = end.status, end.error_msg
        if status is GoalStatus.SUCCEEDED:
            cause = None
        elif active.ending_as is not None:
            status, cause, message = active.ending_as, active.cause, active.why or active.cause.sentence
        goal = self._goals.get(active.goal_id)
        if not is_over(goal.status):
            now_s = self._clock.now_s()
            over = with_status(goal, status, stamp_s=now_s, cause=cause, error_code=end.error_code, error_msg=message)
            self._goals.keep(over)
        active.over.set()

    def _progress(self, active: ActiveGoal, left_m: float) -> None:
        if self._active is active:
            self._goals.progress(active, left_m, self._clock.now_s())


def refuse_while_navigating(navigator: GoalExecutor, what: str) -> None:
    """Raises `ConflictError` where `what` would fight with a goal for the wheels."""
    if navigator.goal_id is not None:
        why = f"{what} has to wait: goal {navigator.goal_id} is under way"
        raise ConflictError(why, code=Refusal.GOAL_UNDER_WAY)
