"""The shell round the core: messages become events, actions become calls, and each failure of a call is an event."""

import asyncio
from collections.abc import Awaitable, Callable, Coroutine
from dataclasses import replace
from typing import Any, assert_never

import structlog

from contracts import mission as wire
from contracts.causes import Refusal
from contracts.description import RobotDescription
from contracts.exploration import Discovery
from contracts.mission import NO_FACTS, EventFacts, EventKind, MissionStatus
from contracts.motion import Hazard
from contracts.robot import EmergencyStop, Goal, RobotState
from contracts.topics import (
    ROBOT_DESCRIPTION,
    ROBOT_EMERGENCY_STOP,
    ROBOT_NAVIGATION,
    ROBOT_STATE,
    VISION_DETECTIONS,
)  # fmt: skip
from contracts.vision import Detections, ValidateRequest
from coordinator.core import actions as do
from coordinator.core import events as ev
from coordinator.core import recording
from coordinator.core.area import SearchArea
from coordinator.core.mission import Mission
from coordinator.core.rules import Rules
from coordinator.core.step import step
from coordinator.coverage.explored_space import ExploredSpace
from coordinator.execution.believed_space import BelievedSpace, believed
from coordinator.execution.explorer import ExplorationNeeds, Explorer
from coordinator.execution.look_reporter import LookReporter
from coordinator.execution.mission_messages import mission_record, mission_status, mission_target
from coordinator.execution.mission_trace import MissionTrace
from coordinator.execution.motion_client import MotionClient
from coordinator.execution.robot_calls import Motion, moved
from coordinator.execution.status_publisher import StatusPublisher
from coordinator.metrics import DETECTIONS_AGE, FAILURES, STEPS
from coordinator.ports import Inference, MissionLog, Robot
from coordinator.settings import Settings
from geometry.grids import MapError
from mesh.bus import Bus
from mesh.clock import Clock
from mesh.errors import MeshError, UnavailableError, UpstreamError
from mesh.metrics import Rounds
from mesh.tasks import Tasks

log = structlog.get_logger()


class MissionRunner:
    """Owns the one mission. `feed` is synchronous: every event is worked out whole before the next."""

    def __init__(
        self,
        *,
        settings: Settings,
        bus: Bus,
        robot: Robot,
        inference: Inference,
        log_: MissionLog,
        looks: LookReporter,
        exploring: ExplorationNeeds,
        queued: Callable[[], tuple[wire.Mission, ...]],
        clock: Clock,
        tasks: Tasks,
    ) -> None:
        self.mission = Mission(rules=Rules.of(settings, None))
        self.description: RobotDescription | None = None
        self.robot_state: RobotState | None = None
        self.robot_state_s = float("-inf")
        self._settings = settings
        self._bus = bus
        self._robot = robot
        self._inference = inference
        self._log = log_
        self._looks = looks
        self._queued = queued
        self._clock = clock
        self._tasks = tasks
        self._motion = MotionClient(
            robot, clock, self._spawn, goal_poll_s=settings.goal_poll_s,
            on_lease=lambda held: self.feed(ev.LeaseAnswered(held)),
        )  # fmt: skip
        self._explorer = Explorer(exploring, self._motion, self.feed, clock, tasks)
        self._explored = ExploredSpace(robot, self.mission.rules, None)
        self.believed: BelievedSpace | None = None  # of the newest mission; none by another rule
        self._query: asyncio.Task[None] | None = None
        self._trace = MissionTrace()
        self._publisher = StatusPublisher(
            bus=bus, log_=log_, clock=clock, period_s=settings.state_period_s, state=self.status,
            target=lambda: mission_target(self.mission), inside=self._trace.inside,
        )  # fmt: skip
        self._recorded = ""

    def start(self) -> None:
        """Begins to listen, tick and publish; returns at once."""
        self._tasks.start("ticks", self._tick())
        self._tasks.start("session", self._robot.hold_session())
        self._publisher.start(self._tasks)
        self._tasks.start("looks", self._looks.send_forever())
        self._tasks.start("robot-state", self._bus.listen(ROBOT_STATE, self._on_robot_state))
        self._tasks.start("robot-description", self._bus.listen(ROBOT_DESCRIPTION, self._on_description))
        self._tasks.start("robot-stop", self._bus.listen(ROBOT_EMERGENCY_STOP, self._on_stop))
        self._tasks.start("robot-navigation", self._bus.listen(ROBOT_NAVIGATION, self._on_navigation))
        self._tasks.start("detections", self._bus.listen(VISION_DETECTIONS, self._on_detections))

    def begin(self, event: ev.Started) -> None:
        """Starts a mission, its recording, and its span in the current trace. Only while the core is idle."""
        self._take_rules()
        self._trace.begin(event.mission_id, "dock" if isinstance(event, ev.DockingStarted) else event.command)
        search = event if isinstance(event, ev.MissionStarted) else None
        self._explored = self.unexplored(search.area if search is not None else None)
        self.believed = believed(self.mission.rules, self.description, search) if search is not None else None
        self._spawn(self._prefetch_map(self._explored))
        header = recording.header_of(self.mission, event.mission_id, self._clock.now_s())
        self._recorded = event.mission_id
        self._log.record(self._recorded, recording.header_line(header))
        self.feed(event)

    def unexplored(self, area: SearchArea | None = None) -> ExploredSpace:
        """What nobody has looked at yet, of the home or of some rooms. What needs the body says so when it is asked."""
        return ExploredSpace(self._robot, self.mission.rules, self.description, area)

    @STEPS.time()
    def feed(self, event: ev.Event) -> None:
        before, now_s = self.mission, self._clock.now_s()
        self.mission, actions = step(before, event, now_s)
        if self._recorded and (actions or self.mission != before):
            taken = recording.Step(now_s, event, actions, self.mission.state)
            self._log.record(self._recorded, recording.step_line(taken))
            if not self.mission.running and self.mission.state.settled:
                self._recorded = ""
        self._trace.enter(self.mission)
        if actions:
            with self._trace.inside():
                for action in actions:
                    self._act(action)
        self._explorer.follow(self.mission)
        self._trace.leave(self.mission, now_s)
        if self.mission is not before and (actions or not isinstance(event, ev.Tick | ev.RobotUpdated)):
            self._note()

    def status(self) -> MissionStatus:
        told = mission_status(self.mission, self._clock.now_s(), queue=self._queued(), trace_id=self._trace.id)
        return told.model_copy(update={"exploration": self._explorer.status(self.mission.robot.map_id)})

    async def discovered(self) -> tuple[Discovery, ...]:
        """By explorations of the home it is in, oldest first. Raises `UnavailableError`."""
        return await self._explorer.discovered(self.mission.robot.map_id)

    @property
    def robot_state_age_s(self) -> float:
        return self._clock.now_s() - self.robot_state_s

    # what comes in

    async def _on_description(self, robot: RobotDescription) -> None:
        """A mission under way goes on with the body it began with."""
        self.description = robot
        self._take_rules()

    def _take_rules(self) -> None:
        if self.description is not None and not self.mission.running:
            rules = Rules.of(self._settings, self.description)
            self.mission = self.mission if rules == self.mission.rules else replace(self.mission, rules=rules)

    async def _tick(self) -> None:
        rounds = Rounds("mission")
        while True:
            rounds.turn()
            self.feed(ev.Tick())
            self._publisher.tick()
            await self._clock.sleep(self._settings.tick_period_s)

    async def _on_robot_state(self, state: RobotState) -> None:
        self.robot_state, self.robot_state_s = state, self._clock.now_s()
        stop = state.emergency_stop
        self.feed(
            ev.RobotUpdated(
                stamp_s=state.stamp_s,
                pose=state.pose,
                odometry=state.odometry,
                docked=state.docked,
                speed_m_s=abs(state.twist.linear_x),
                stopped=stop.latched,
                epoch=stop.epoch,
                stop_reason=stop.reason,
                map_id=state.map_id,
                lifted=Hazard.WHEEL_DROP in state.hazards,
            )
        )

    async def _on_stop(self, stop: EmergencyStop) -> None:
        self.feed(ev.StopLatched(stop.epoch, stop.reason) if stop.latched else ev.StopReset(stop.epoch))

    async def _on_navigation(self, goal: Goal) -> None:
        self._motion.on_goal_update(goal)

    async def _on_detections(self, seen: Detections) -> None:
        DETECTIONS_AGE.observe(max(0.0, self._clock.now_s() - seen.stamp_s))
        self.feed(ev.DetectionsSeen(seen))

    # what goes out

    def _act(self, action: do.Action) -> None:
        epoch = self.mission.epoch
        match action:
            case do.Say():
                self._publisher.say(self.mission.id, action)
            case do.RecordLook() | do.KeepPicture():
                self._keep(action)
            case do.StopMotion():
                self._motion.stop(epoch)
            case do.BeginExploration():
                self._explorer.explore(action, self.mission, self.description)
            case do.SetVelocity(twist=twist, duration_s=duration_s):
                self._motion.send_velocity(twist, duration_s, epoch)
            case do.Celebrate():
                if self._settings.celebrate:
                    self._spawn(self._celebrate())
            case do.Undock() | do.Dock() | do.Navigate() | do.Rotate() | do.Drive():
                self._motion.start(lambda: self._call(action.call, lambda: self._move(action, epoch)), epoch)
            case do.Validate() | do.PlanCoverage():
                if self._query is not None:
                    self._query.cancel()
                self._query = self._spawn(self._call(action.call, lambda: self._ask(action)))
            case _:
                assert_never(action)

    def _keep(self, action: do.RecordLook | do.KeepPicture) -> None:
        match action:
            case do.RecordLook(pose=pose, seen=seen, moving=moving):
                if self.believed is not None:
                    self.believed.look(pose, seen, moving=moving)
                if self._settings.looks_to_memory and not moving:
                    self._looks.add(action)
                share = self._explored.look(pose)
                if share is not None:
                    self.feed(ev.CoverageLooked(share))
            case do.KeepPicture():
                self._spawn(self._keep_picture(action, self.mission.id))

    async def _call(self, call: int, work: Callable[[], Awaitable[ev.Event]]) -> None:
        """The call's answer as an event, or its failure."""
        try:
            event = await work()
        except (UnavailableError, UpstreamError) as error:
            event = ev.CallFailed(call, error.service, error.said, _refusal(error))
        except (MeshError, MapError) as error:
            event = ev.CallFailed(call, "robot_bridge", str(error))
        except TimeoutError:
            event = ev.CallFailed(call, "coordinator", "the call took too long")
        if isinstance(event, ev.CallFailed):
            FAILURES.labels(event.service).inc()
        self.feed(event)

    async def _move(self, action: Motion, epoch: int) -> ev.Event:
        try:
            return await moved(action, self._robot, self._motion, epoch)
        except UnavailableError:
            self._motion.mark_uncertain(epoch)
            raise

    async def _ask(self, action: do.Validate | do.PlanCoverage) -> ev.Event:
        async with asyncio.timeout(action.timeout_s):
            match action:
                case do.Validate(call=call, target=target, box=box, moving=moving):
                    request = ValidateRequest(
                        target=target, bbox_xyxy=box.bbox_xyxy, after_stamp_s=box.stamp_s, moving=moving
                    )
                    return ev.Validated(call, await self._inference.validate(request, timeout_s=action.timeout_s))
                case do.PlanCoverage() if self.believed is not None:
                    return await self._choose(self.believed, action)
                case do.PlanCoverage(call=call, avoid=avoid):
                    pose = self.mission.robot.pose
                    plan = await self._explored.plan(pose, avoid)
                    return ev.CoveragePlanned(call, plan.points, plan.free_area_m2, plan.trouble)

    async def _choose(self, believed: BelievedSpace, action: do.PlanCoverage) -> ev.CoveragePlanned:
        here = self.mission.robot.pose
        if here is None:
            raise UnavailableError("robot_bridge", "the robot does not know where it is")
        grid = (await self._explored.refresh()).grid
        choice = await believed.choose(grid, here, action)
        points, headings = ((), ()) if choice.view is None else ((choice.view.pose,), choice.view.headings)
        return ev.CoveragePlanned(action.call, points, grid.free_area_m2, choice.trouble, headings, choice.why)

    async def _celebrate(self) -> None:
        try:
            await self._robot.celebrate()
        except MeshError as error:
            log.warning("no celebration", error=error.detail)

    async def _keep_picture(self, action: do.KeepPicture, mission_id: str) -> None:
        try:
            async with asyncio.timeout(self._settings.call_timeout_s):
                jpeg = await self._inference.evidence(action.validation_id)
        except (MeshError, TimeoutError) as error:
            log.warning("no picture of what was judged", error=str(error))
        else:
            self._log.keep_picture(mission_id, action.number, jpeg)

    async def _prefetch_map(self, explored: ExploredSpace) -> None:
        try:
            await explored.refresh()
        except (MeshError, MapError) as error:
            log.warning("no map yet", error=str(error))

    def tell(self, mission: wire.Mission, kind: EventKind, text: str, data: EventFacts = NO_FACTS) -> None:
        """A line of the timeline of a mission that does not run: queued, or over before it began."""
        self._log.upsert(mission)
        self._publisher.say(mission.id, do.Say(self.mission.state, kind, text, data))
        self._publisher.changed()

    def _note(self) -> None:
        record = mission_record(self.mission, self._trace.id)
        if record is not None:
            self._log.upsert(record)
        self._publisher.changed()

    def _spawn(self, work: Coroutine[Any, Any, Any]) -> "asyncio.Task[Any]":
        return self._tasks.start("call", work, forever=False)


def _refusal(error: MeshError) -> Refusal | None:
    """Which refusal it was, where the other service is robot_bridge and says so."""
    return Refusal(error.code) if error.code in set(Refusal) else None
