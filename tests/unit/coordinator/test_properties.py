"""From any stream of events: the core stays in its table, moves only when it may, and answers the same twice."""

import itertools
from collections.abc import Callable
from typing import Any, assert_never

from hypothesis import given, settings
from hypothesis import strategies as st

from contracts.causes import GoalCause
from contracts.exploration import ExplorationEnd, ExplorationMode
from contracts.geometry import Point3D, Pose2D
from contracts.measuring import Measurement
from contracts.mission import MissionKind, MissionState, Outcome
from contracts.motion import MotionEnd
from contracts.robot import GoalStatus
from contracts.vision import Detection, Detections, Target, Validation, Verdict, Vote
from coordinator.core import actions as do
from coordinator.core import events as ev
from coordinator.core import recording
from coordinator.core.actions import MOTION
from coordinator.core.activities import (
    AwaitingFrame,
    BeingExplored,
    Docking,
    Driving,
    Idle,
    Navigating,
    Paused,
    PlanningCoverage,
    Rotating,
    Starting,
    Steering,
    Undocking,
    Validating,
    Waiting,
    Waking,
)
from coordinator.core.mission import Mission, SearchPose
from coordinator.core.motions import PlaceLeg, PlainMotion, RoundLeg, StraightLeg, TurnLeg
from coordinator.core.rules import ApproachRule, CenteringRule, CoverageRule, Rules, ScanRule, ValidationRule
from coordinator.core.step import step
from coordinator.core.transitions import ALLOWED
from support.mission_script import rules_of

metres = st.floats(-5.0, 5.0)
poses = st.builds(Pose2D, x=metres, y=metres, yaw=st.floats(-3.0, 3.0))
calls = st.integers(-3, 0)
"""Relative to the newest call: 0 answers it, others come too late."""
LOCALISED = ("robot", Pose2D(x=0.0, y=0.0, yaw=0.0), False, 0.0)
TARGET = Target(label="bottle", description="red bottle")


Box = tuple[float, str | None, float, Measurement | None]


def detections(stamp_s: float, boxes: list[Box], pose: Pose2D | None) -> Detections:
    found = tuple(
        Detection(label="bottle", confidence=sure, bbox_xyxy=(u - 8, 100.0, u + 8, 140.0), colour=colour, measurement=m)
        for u, colour, sure, m in boxes
    )
    return Detections(stamp_s=stamp_s, image_width_px=320, image_height_px=240, pose=pose, detections=found)


def measured(distance_m: float | None, pose: Pose2D) -> Measurement:
    point = Point3D(x=pose.x, y=pose.y, z=0.2) if distance_m is not None else None
    return Measurement(distance_m=distance_m, sigma_m=0.02, base_point=point, map_point=point)


def validated(call: int, confirmed: bool, score: float) -> ev.Validated:
    vote = Vote(voter="clip", verdict=Verdict.YES if confirmed else Verdict.NO, score=score, threshold=0.4)
    return ev.Validated(
        call,
        Validation(confirmed=confirmed, votes=(vote,), stamp_s=1.0, image_width_px=320, image_height_px=240),
    )


measurements = st.none() | st.builds(measured, st.none() | st.floats(0.2, 4.0), poses)
boxes = st.lists(
    st.tuples(st.floats(10, 310), st.sampled_from(["red", "blue", None]), st.floats(0.3, 1.0), measurements), max_size=3
)
fitting = st.tuples(
    st.just("fit"), st.sampled_from([True, True, True, False]), st.sampled_from([0.4, 0.9, 1.3, 2.0, 2.8]), metres
)
ending = st.tuples(st.just("end"), st.sampled_from(MotionEnd))
"""The motion under way ends so."""
noise = st.one_of(
    st.tuples(st.just("robot"), poses | st.none(), st.booleans(), st.floats(0.0, 0.3), st.booleans()),
    st.tuples(st.just("lease"), st.sampled_from(MotionEnd)),
    st.tuples(st.just("see"), boxes),
    st.tuples(st.just("undocked"), calls),
    st.tuples(st.just("docked"), calls),
    st.tuples(st.just("lie"), st.sampled_from([-1e6, -60.0, 60.0, 1e6])),
    st.tuples(st.just("goal"), calls, st.sampled_from(GoalStatus), st.none() | st.sampled_from(GoalCause)),
    st.tuples(st.just("motion"), calls, st.sampled_from(MotionEnd), st.floats(-1, 2)),
    st.tuples(st.just("validated"), calls, st.booleans(), st.floats(0.0, 1.0)),
    st.tuples(st.just("coverage"), calls, st.lists(poses, max_size=3).map(tuple)),
    st.tuples(st.just("told"), calls, st.sampled_from(ExplorationMode)),
    st.tuples(st.just("explored"), calls, st.sampled_from(ExplorationEnd), st.integers(0, 2)),
    st.tuples(st.just("failed"), calls, st.sampled_from(["inference", "robot_bridge"])),
)
places = st.builds(PlaceLeg, metres, metres, st.none() | st.floats(-3.0, 3.0), st.just("there"), st.booleans())
legs = st.one_of(
    places, st.builds(TurnLeg, st.floats(-6.0, 6.0)), st.builds(StraightLeg, st.floats(0.05, 2.0)), st.builds(RoundLeg)
)
motions = st.builds(
    PlainMotion,
    st.just("as asked"),
    st.lists(legs, max_size=3).map(tuple),
    limit_s=st.none() | st.just(30.0),
    explores=st.booleans(),
)
anything = st.one_of(
    st.tuples(st.just("start"), st.lists(st.builds(SearchPose, poses), max_size=3).map(tuple)),
    st.tuples(st.just("tick"), st.sampled_from([0.1, 0.1, 1.0, 5.0, 40.0, 200.0])),
    st.tuples(st.just("latch"), st.booleans()),
    st.tuples(st.just("reset")),
    st.tuples(
        st.just("person"),
        st.sampled_from(
            [
                ev.CancelRequested(),
                *(ev.PauseRequested(for_s) for for_s in (None, None, 30.0, 0.0)),
                ev.ResumeRequested(),
            ]
        ),
    ),
    st.tuples(st.just("dock")),
    st.tuples(st.just("move"), motions),
    noise,
    noise,
    noise,
)

steps = st.one_of(fitting, fitting, ending, anything)
"""Mostly what the core waits for; the rest is anything at all."""
prefixes = st.tuples(st.integers(0, 40), st.sampled_from([0.4, 1.3, 2.0, 2.8])).map(
    lambda drawn: [("fit", True, drawn[1], 0.0)] * drawn[0]
)
"""A mission going well, to begin deep inside it."""


ANSWERS: dict[str, Callable[..., ev.Event]] = {
    "undocked": ev.Undocked,
    "docked": ev.Docked,
    "goal": lambda call, status, cause: ev.GoalEnded(call, status, cause=cause),
    "motion": lambda call, end, metres: ev.MotionEnded(call, end, driven_m=metres),
    "validated": validated,
    "coverage": lambda call, points: ev.CoveragePlanned(call, points, 10.0),
    "told": lambda call, mode: ev.ExplorationTold(call, mode, "as it is"),
    "explored": ev.ExplorationEnded,
    "failed": lambda call, service: ev.CallFailed(call, service, "away"),
}


class Player:
    def __init__(self, rules: Rules) -> None:
        self.mission, self.now_s, self.epoch = Mission(rules=rules), 100.0, 0
        self.log: list[tuple[ev.Event, float]] = []
        self.ended: MotionEnd | None = None
        """How the last motion of this approach ended, or would."""

    def event(self, what: tuple[Any, ...]) -> ev.Event:
        kind, *rest = what
        if kind in ANSWERS:
            return ANSWERS[kind](self.mission.calls + rest[0], *rest[1:])
        return getattr(self, f"on_{kind}")(*rest)

    def on_start(self, views: tuple[SearchPose, ...]) -> ev.Event:
        return ev.MissionStarted("m", "find the red bottle", TARGET, "rules", views)

    def on_dock(self) -> ev.Event:
        return ev.DockingStarted("d", "a low battery")

    def on_move(self, motion: PlainMotion) -> ev.Event:
        return ev.MotionStarted("a", motion.what, motion)

    def on_lie(self, seconds: float) -> ev.Event:
        """A frame of another time, with the target in its middle."""
        return ev.DetectionsSeen(detections(max(0.0, self.now_s + seconds), [(160.0, "red", 0.9, None)], None))

    def on_tick(self, seconds: float) -> ev.Event:
        self.now_s += seconds
        return ev.Tick()

    def on_robot(self, pose: Pose2D | None, docked: bool, speed_m_s: float, lifted: bool = False) -> ev.Event:
        return ev.RobotUpdated(self.now_s, pose, pose, docked, speed_m_s, False, self.epoch, lifted=lifted)

    def on_lease(self, held: MotionEnd) -> ev.Event:
        return ev.LeaseAnswered(held)

    def on_end(self, end: MotionEnd) -> ev.Event:
        """The motion under way ends so; what else is waited for goes well."""
        activity = self.mission.activity
        if isinstance(activity, Rotating | Driving):
            return ev.MotionEnded(activity.call, end, driven_m=0.1, text=end.sentence)
        return self.on_fit(True, 1.3, 0.0)

    def on_latch(self, seen: bool) -> ev.Event:
        """A stop, told as such or only by the epoch that rose with it."""
        self.epoch += 1
        missed = ev.RobotUpdated(self.now_s, None, None, False, 0.0, False, self.epoch)
        return ev.StopLatched(self.epoch, "stop") if seen else missed

    def on_fit(self, good: bool, distance_m: float, x: float) -> ev.Event:  # noqa: PLR0911, PLR0912 - one per activity
        """What the mission waits for now, well or badly."""
        activity, call = self.mission.activity, self.mission.activity.call
        point = Pose2D(x=distance_m, y=0.0 if good else x, yaw=0.0)
        match activity:
            case Idle() if self.mission.state in {MissionState.IDLE, MissionState.DONE}:
                return self.on_start((SearchPose(point),) if good else ())
            case Idle():
                return self.on_reset()
            case Paused():
                return ev.ResumeRequested()
            case Undocking():
                return ev.Undocked(call)
            case PlanningCoverage():
                return ev.CoveragePlanned(call, (point,), 10.0)
            case Docking():
                return ev.Docked(call) if good else ev.CallFailed(call, "robot_bridge", "the base gave up")
            case Navigating(candidates=(first, *_)) if good and self.mission.robot.pose != first.pose:
                return self.on_robot(first.pose, False, 0.0)
            case Navigating():
                return ev.GoalEnded(call, GoalStatus.SUCCEEDED if good else GoalStatus.ABORTED, 104)
            case Rotating() | Driving():
                return ev.MotionEnded(call, MotionEnd.COMPLETED if good else MotionEnd.BLOCKED, driven_m=0.3)
            case BeingExplored():
                return ev.ExplorationEnded(call, ExplorationEnd.EXPLORED, 0 if good else 3)
            case Validating():
                return validated(call, good, 0.38)
            case Steering(next_depth_s=due_s) if self.now_s < due_s:
                return self.on_tick(2.5)
            case AwaitingFrame() | Waking() | Steering():
                return self.on_see([(160.0 if good else 60.0, "red", 0.9, measured(distance_m, point))])
            case Waiting() | Starting():
                return self.on_tick(2.5)
            case _:
                assert_never(activity)

    def on_reset(self) -> ev.Event:
        return ev.StopReset(self.epoch)

    def on_person(self, event: ev.Event) -> ev.Event:
        return event

    def on_see(self, seen: list[Box]) -> ev.Event:
        self.now_s += 0.3
        return ev.DetectionsSeen(detections(self.now_s, seen, self.mission.robot.pose))

    def play(self, event: ev.Event) -> tuple[Mission, tuple[do.Action, ...]]:
        self.log.append((event, self.now_s))
        before = self.mission
        self.mission, actions = step(before, event, self.now_s)
        if before.state is not MissionState.APPROACHING:
            self.ended = None
        match event:
            case ev.MotionEnded(call=call, end=end) if call == before.activity.call:
                self.ended = end
            case ev.LeaseAnswered(held=held):
                self.ended = held
            case _:
                pass
        return before, actions


def check_path(before: MissionState, actions: tuple[do.Action, ...], after: MissionState) -> None:
    """Each change of state is said; together they lead from one to the other along the table."""
    here = before
    for say in actions:
        if isinstance(say, do.Say) and say.data.before is not None:
            assert say.data.before is here
            here = say.state
            assert here in ALLOWED[say.data.before]
            assert say.text
    assert here is after


@settings(max_examples=300)
@given(
    st.tuples(prefixes, st.lists(steps, max_size=50)).map(lambda parts: [*parts[0], *parts[1]]),
    st.sampled_from(ApproachRule),
    st.sampled_from(CenteringRule),
    st.sampled_from(CoverageRule),
    st.sampled_from(ScanRule),
    st.sampled_from(ValidationRule),
    st.none() | motions,
)
def test_the_core_never_leaves_its_table_and_never_moves_when_it_may_not(
    stream: list[tuple[Any, ...]],
    approach: ApproachRule,
    centering: CenteringRule,
    coverage: CoverageRule,
    scan: ScanRule,
    validation: ValidationRule,
    motion: PlainMotion | None,
) -> None:
    looking = {"coverage_rule": coverage, "scan_rule": scan, "validation_rule": validation}
    player = Player(rules_of(approach_rule=approach, centering_rule=centering, **looking))
    start = player.mission
    for what in [LOCALISED, ("move", motion) if motion is not None else ("start", ()), *stream]:
        before, actions = player.play(player.event(what))
        check_path(before.state, actions, player.mission.state)
        moving = [a for a in actions if isinstance(a, MOTION)]
        may_not = player.mission.state.resting or player.mission.paused or player.mission.robot.stopped
        assert not (moving and may_not)
        assert player.mission.state.resting or player.mission.running
        check_ending(player.mission)
        check_find(before, player)
    again = start
    for event, now_s in player.log:
        again, _ = step(again, event, now_s)
    assert again == player.mission


def check_find(before: Mission, player: Player) -> None:
    """Out of an approach only what was measured within reach is found, or what something stands before."""
    report = player.mission.report
    if not before.running or before.state is not MissionState.APPROACHING or report is None or report.found is None:
        return
    distance_m, reach_m = report.found.distance_m, player.mission.rules.reach_m + 0.05
    arrived = player.ended is None or player.ended.completed or player.ended.says_something_is_ahead
    assert arrived or (distance_m is not None and distance_m <= reach_m), player.ended


def check_ending(mission: Mission) -> None:
    """Whoever ends says how, why, and on what it rests."""
    if mission.outcome is None:
        assert mission.report is None
        return
    report = mission.report
    assert report is not None
    assert report.text
    assert (report.cause != "") == (mission.outcome in {Outcome.ABORTED, Outcome.CANCELED})
    assert (report.ended_by is None) == (mission.outcome in {Outcome.FOUND, Outcome.DOCKED, Outcome.DONE})
    assert (report.found is not None) == (mission.outcome is Outcome.FOUND)
    assert mission.outcome is not Outcome.UNSURE or report.candidates
    assert mission.outcome is not Outcome.DOCKED or mission.kind is MissionKind.DOCK
    assert (mission.outcome is Outcome.DONE) <= (mission.kind is MissionKind.MOVE)


@settings(max_examples=60)
@given(
    st.tuples(prefixes, st.lists(steps, max_size=40)).map(lambda parts: [*parts[0], *parts[1]]),
    st.sampled_from(ApproachRule),
    st.none() | motions,
)
def test_written_down_and_read_back_it_decides_the_same_again(
    stream: list[tuple[Any, ...]], approach: ApproachRule, motion: PlainMotion | None
) -> None:
    player = Player(rules_of(approach_rule=approach))
    player.play(player.event(LOCALISED))
    lines = [recording.header_line(recording.header_of(player.mission, "m", player.now_s))]
    for what in [("move", motion) if motion is not None else ("start", ()), *stream]:
        before, actions = player.play(player.event(what))
        if actions or player.mission != before:
            event, now_s = player.log[-1]
            lines.append(recording.step_line(recording.Step(now_s, event, actions, player.mission.state)))
    again = list(recording.replay(recording.read(lines)))
    assert all(one.same for one in again)
    assert again[-1].after == player.mission


@settings(max_examples=100)
@given(prefixes, st.lists(steps, max_size=10), st.sampled_from(ApproachRule), st.none() | motions)
def test_left_alone_every_mission_ends_within_its_deadlines(
    prefix: list[tuple[Any, ...]], rest: list[tuple[Any, ...]], approach: ApproachRule, motion: PlainMotion | None
) -> None:
    player = Player(rules_of(approach_rule=approach))
    for what in [LOCALISED, ("move", motion) if motion is not None else ("start", ()), *prefix, *rest]:
        player.play(player.event(what))
    limit_s = player.now_s + player.mission.rules.mission_timeout_s + player.mission.rules.pause_timeout_s + 10.0
    while player.mission.running:
        player.now_s += 1.0
        assert player.now_s < limit_s
        player.play(ev.RobotUpdated(player.now_s, None, None, False, 0.0, False, player.mission.robot.epoch))
        player.play(ev.Tick())
    check_ending(player.mission)


@settings(max_examples=60)
@given(prefixes, st.lists(noise, min_size=1, max_size=12), st.sampled_from(ApproachRule), st.booleans())
def test_whatever_keeps_coming_every_mission_ends_within_its_deadlines(
    prefix: list[tuple[Any, ...]], stream: list[tuple[Any, ...]], approach: ApproachRule, docking: bool
) -> None:
    player = Player(rules_of(approach_rule=approach))
    for what in [LOCALISED, ("dock",) if docking else ("start", ()), *prefix]:
        player.play(player.event(what))
    limit_s = player.now_s + player.mission.rules.mission_timeout_s + player.mission.rules.pause_timeout_s + 10.0
    coming = itertools.cycle(stream)
    while player.mission.running:
        assert player.now_s < limit_s
        player.play(player.event(next(coming)))
        player.now_s += 2.0
        player.play(ev.Tick())
    check_ending(player.mission)
