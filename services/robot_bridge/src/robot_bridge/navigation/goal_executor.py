"""Goals from the request to their end: checks, preflight, Nav2, progress, another try, and what to tell whom."""

import asyncio
import uuid
from collections.abc import Callable
from dataclasses import replace
from itertools import count

import structlog
from opentelemetry.trace import Span
from prometheus_client import Histogram
from pydantic import Field

from contracts.causes import GoalCause, Refusal
from contracts.geometry import Pose2D
from contracts.robot import CandidatePose, Goal, GoalRequest, GoalStatus, NavigationState, PathReply, PathRequest
from mesh.clock import Clock
from mesh.errors import ConflictError, UnavailableError
from mesh.tasks import Tasks
from mesh.tracing import NO_SPAN, Tracer, failed, inside
from robot_bridge.motion.first_twist import tell_first_twist
from robot_bridge.motion.navigation_hold import NavigationHold
from robot_bridge.motion.velocity_mux import NAVIGATION_SOURCE, VelocityMux
from robot_bridge.navigation import maps
from robot_bridge.navigation.goal_phases import Asking, Driving, Ending, Over, Recovering
from robot_bridge.navigation.goal_states import cause_of, error_name, is_over, retries, with_status
from robot_bridge.navigation.goal_store import ActiveGoal, GoalStore
from robot_bridge.navigation.path_check import GoalRegion, PathCheck, PathChecker, PathLimits, best_or_first, path_reply
from robot_bridge.navigation.recovery import Recovery, explained, is_stuck
from robot_bridge.ports import AcceptedGoal, GoalEnd, Robot

log = structlog.get_logger()

CANCEL_S_MAX = 2.0
GOALS = Histogram(
    "robot_bridge_goal_seconds",
    "from the request of a goal to its end",
    ["status"],
    buckets=(1.0, 3.0, 10.0, 20.0, 30.0, 60.0, 120.0),
)
TRACER = Tracer(__name__)
FAULTS = frozenset({GoalStatus.ABORTED, GoalStatus.REJECTED, GoalStatus.TIMED_OUT})
"""A goal that somebody cancelled, a stop too, did what it should."""


class GoalLimits(PathLimits):
    nav2_active_wait_s: float = Field(default=2.0, ge=0.0, description="for Nav2 to become active, before a goal")
    ring_radius_m: float = Field(default=0.6, ge=0.0, le=3.0, description="how far from the wanted pose a goal may end")
    retries_max: int = Field(default=2, ge=0, le=5, description="of a goal that Nav2 gave up under way, at most")


class GoalExecutor:
    """Lives in asyncio. At most one goal is under way. `publish` hears of each as `GoalStore` tells."""

    def __init__(
        self,
        *,
        robot: Robot,
        wheels: VelocityMux,
        recovery: Recovery,
        clock: Clock,
        tasks: Tasks,
        limits: GoalLimits,
        publish: Callable[[Goal], None],
    ) -> None:
        self._robot = robot
        self._wheels = wheels
        self._recovery = recovery
        self._clock = clock
        self._tasks = tasks
        self._limits = limits
        self._preflight = PathChecker(robot, limits)
        self._publish = publish
        self._goals = GoalStore(self._tell)
        self._span: Span = NO_SPAN
        """Of the goal under way."""
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
            await self._need_nav2(self._limits.nav2_active_wait_s)
            await self._end_active(GoalCause.PREEMPTED)
            if request.clear_costmaps:
                await self._preflight.clear_costmaps(self._clock)
            region = self._region(request.candidates, request)
            checked = await best_or_first(self._preflight, region)
            self._check(request)
            return await self._begin(request, region, checked)

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
            if (accepted := active.state.accepted) is not None:
                accepted.cancel()
            self._finish(active, GoalEnd(GoalStatus.CANCELED), cause)

    def end_session(self, session_id: str) -> None:
        if (active := self._active) is not None and active.session_id == session_id:
            self.stop(GoalCause.SESSION_ENDED)

    async def path(self, request: PathRequest) -> PathReply:
        """Nav2's plan to the pose or the nearest one on the ring, or its error code; nothing moves."""
        maps.check_in_map(maps.known(self._robot.senses), request.goal)
        await self._need_nav2(0.0)
        region = self._region((CandidatePose(pose=request.goal),), request)
        return path_reply(await self._preflight.best(region, request.start))

    def _region(self, candidates: tuple[CandidatePose, ...], request: GoalRequest | PathRequest) -> GoalRegion:
        radius_m = self._limits.ring_radius_m if request.ring_radius_m is None else request.ring_radius_m
        return GoalRegion(candidates, radius_m, request.look_at)

    def _check(self, request: GoalRequest) -> None:
        self._wheels.check(request.epoch, request.session_id)
        maps.check_in_map(maps.known(self._robot.senses), *(each.pose for each in request.candidates))

    async def _need_nav2(self, wait_s: float) -> None:
        """Its lifecycle has to be active; it may be about to become so."""
        senses = self._robot.senses
        await senses.nav2_missing.wait_for(lambda _: not senses.why_no_nav2(self._clock.now_s()), wait_s)
        if missing := senses.why_no_nav2(self._clock.now_s()):
            raise UnavailableError("nav2", missing, code=Refusal.NO_NAV2)

    async def _begin(self, request: GoalRequest, region: GoalRegion, checked: PathCheck) -> Goal:
        now_s, wanted = self._clock.now_s(), request.candidates[0].pose
        pose = checked.pose or wanted
        goal = Goal(
            id=uuid.uuid4().hex,
            pose=pose,
            wanted=wanted,
            candidate=checked.candidate,
            status=GoalStatus.PENDING,
            stamp_s=now_s,
        )
        active = ActiveGoal(goal.id, region, request.epoch, request.session_id, now_s, now_s + request.timeout_s)
        self._wheels.open_navigation(goal.id, request.epoch, request.session_id)
        self._wheels.hold_navigation(goal.id)
        self._active = active
        self._span = TRACER.begin("goal", {"goal.id": goal.id, "goal.x_m": pose.x, "goal.y_m": pose.y})
        tell_first_twist(
            self._tasks, self._wheels, self._span,
            source=NAVIGATION_SOURCE, since_s=now_s, within_s=request.timeout_s,
        )  # fmt: skip
        self._goals.keep(goal)
        if checked.unreachable:
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
        if self._active is active:
            self._goals.keep(with_status(self._goals.get(goal.id), GoalStatus.EXECUTING, stamp_s=self._clock.now_s()))
            self._tasks.start("goal", self._follow(active), forever=False)
        return self._goals.get(goal.id)

    async def _ask_nav2(self, active: ActiveGoal, pose: Pose2D) -> None:
        """Nav2 takes the goal or rejects it, which ends it."""
        accepted = await self._robot.navigate(pose, lambda left_m: self._progress(active, left_m))
        match active.state:
            case Asking() | Ending() if accepted is None:
                first = self._goals.get(active.goal_id).status is GoalStatus.PENDING
                rejected = GoalStatus.REJECTED if first else GoalStatus.ABORTED
                self._finish(active, GoalEnd(rejected), GoalCause.REJECTED)
            case Asking() if accepted is not None:
                active.become(Driving(accepted))
                self._wheels.release_navigation(active.goal_id)
            case ended if accepted is not None:  # while Nav2 was thinking
                accepted.cancel()
                if isinstance(ended, Ending):
                    active.become(replace(ended, accepted=accepted))
            case _:
                pass

    async def _follow(self, active: ActiveGoal) -> None:
        """Until Nav2 ends it, its time is up, or Nav2 is gone; tries again where Nav2's code promises something."""
        for attempt in count(1):
            accepted = active.state.accepted
            patient = attempt > self._limits.retries_max  # the last: whoever stands there may go
            end = await self._until_end(active, accepted, patient=patient) if accepted is not None else None
            if accepted is None or end is None:
                return
            self._wheels.hold_navigation(active.goal_id)  # its controller may drive on without a goal
            hold = self._wheels.navigation_hold()
            if cause_of(end) is GoalCause.NAV2_SILENT and await accepted.was_preempted():
                cause = GoalCause.FOREIGN_GOAL
            else:
                end, cause = explained(end, hold)
            last = attempt > min(retries(end), self._limits.retries_max)
            if last or cause is GoalCause.FOREIGN_GOAL or not isinstance(active.state, Driving):
                self._finish(active, end, cause)
                return
            try:
                await self._try_again(active, end, attempt + 1, hold)
            except UnavailableError as error:
                gone = GoalEnd(GoalStatus.ABORTED, end.error_code, f"{end.error_msg}; {error.detail}")
                self._finish(active, gone, GoalCause.NAV2_GONE)

    async def _try_again(self, active: ActiveGoal, end: GoalEnd, attempt: int, hold: NavigationHold | None) -> None:
        """With room about the robot and the costmaps cleared; from the third time on to a roomier pose on the ring."""
        goal, name = self._goals.get(active.goal_id), error_name(end.error_code)
        log.info("Nav2 gave up under way; trying again", goal=goal.id, error=name, attempt=attempt)
        why = end.error_msg or name or cause_of(end).sentence
        told = {"attempt": attempt, "error_code": end.error_code, "error_name": name, "error_msg": why}
        active.become(Recovering())
        self._goals.keep(goal.model_copy(update=told | {"stamp_s": self._clock.now_s()}))
        await self._recovery.make_room(active, hold)
        await self._preflight.clear_costmaps(self._clock)
        roomier = (await self._preflight.roomier(active.region, goal.pose)).pose if attempt > 2 else None
        match active.state:
            case Recovering():
                active.become(Asking())
                if roomier is not None:
                    moved = {"pose": roomier, "candidate": None}
                    self._goals.keep(self._goals.get(goal.id).model_copy(update=moved))
                await self._ask_nav2(active, roomier or goal.pose)
            case Ending():
                self._finish(active, end)
            case _:
                pass

    async def _until_end(self, active: ActiveGoal, accepted: AcceptedGoal, *, patient: bool) -> GoalEnd | None:
        """How Nav2 ended it; none when it is over already. Not `patient`, it is ended where the robot is stuck."""
        end = asyncio.ensure_future(accepted.end())
        grace_s: float | None = None
        try:
            while not end.done() and self._active is active:
                await asyncio.wait({end}, timeout=0.25)
                if self._active is not active:
                    return None
                now_s = self._clock.now_s()
                if now_s > active.deadline_s and not isinstance(active.state, Ending):
                    self._end_soon(active, GoalStatus.TIMED_OUT, GoalCause.TIMED_OUT)
                if isinstance(active.state, Ending) and grace_s is None:
                    grace_s = now_s + CANCEL_S_MAX
                if missing := self._robot.senses.why_no_nav2(now_s):
                    gone = GoalEnd(GoalStatus.ABORTED, error_msg=f"Nav2 is gone: {missing}")
                    self._finish(active, gone, GoalCause.NAV2_GONE)
                elif not patient and is_stuck(self._wheels.navigation_hold()):
                    accepted.cancel()
                    return GoalEnd(GoalStatus.ABORTED)
                elif grace_s is not None and now_s > grace_s:
                    self._finish(active, GoalEnd(GoalStatus.CANCELED))
            return end.result() if end.done() and self._active is active else None
        finally:
            end.cancel()

    async def _end_active(self, cause: GoalCause) -> None:
        if (active := self._active) is not None:
            await self.cancel(active.goal_id, cause)

    def _end_soon(self, active: ActiveGoal, status: GoalStatus, cause: GoalCause) -> None:
        """Nav2's velocity stops passing now; the goal ends when Nav2 confirms."""
        self._wheels.close_navigation(active.goal_id)
        if (accepted := active.state.accepted) is not None:
            accepted.cancel()
        if not isinstance(active.state, Ending):
            active.become(Ending(status, cause, accepted))

    def _finish(self, active: ActiveGoal, end: GoalEnd, cause: GoalCause | None = GoalCause.NAV2) -> None:
        if self._active is not active:
            return
        asked = active.state
        self._active = None
        active.become(Over())
        self._wheels.close_navigation(active.goal_id)
        active.over.set()
        status, message = end.status, end.error_msg
        if status is GoalStatus.SUCCEEDED:
            cause = None
        elif isinstance(asked, Ending):
            status, cause, message = asked.status, asked.cause, asked.cause.sentence
        goal = self._goals.get(active.goal_id)
        if not is_over(goal.status):
            now_s = self._clock.now_s()
            over = with_status(goal, status, stamp_s=now_s, cause=cause, error_code=end.error_code, error_msg=message)
            self._goals.keep(over)
        about = {"goal.status": status.value, "goal.cause": cause.value if cause is not None else ""}
        took_s = self._clock.now_s() - active.begun_s
        asyncio.get_running_loop().call_soon(_record, self._span, about, took_s)  # an emergency stop is stored first

    def _tell(self, goal: Goal) -> None:
        with inside(self._span):
            self._publish(goal)

    def _progress(self, active: ActiveGoal, left_m: float) -> None:
        if self._active is active:
            self._goals.progress(active, left_m, self._clock.now_s())


def _record(span: Span, about: dict[str, str], took_s: float) -> None:
    GOALS.labels(about["goal.status"]).observe(took_s)
    span.set_attributes(about)
    if about["goal.status"] in FAULTS:
        failed(span, about["goal.cause"])
    span.end()


def refuse_while_navigating(navigator: GoalExecutor, what: str) -> None:
    """Raises `ConflictError` where `what` would fight with a goal for the wheels."""
    if navigator.goal_id is not None:
        why = f"{what} has to wait: goal {navigator.goal_id} is under way"
        raise ConflictError(why, code=Refusal.GOAL_UNDER_WAY)
