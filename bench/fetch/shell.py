"""Runs the manipulation core on the simulated arm: each command is done to its end, and answered by its event.

The robot stands where the thing is in reach; it does not drive there. What it knows of the thing is the truth with an
error drawn from a seed: no picture is looked at yet. Ground truth is read only to be written down.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from random import Random
from typing import Final

import numpy as np

from bench.fetch.arm import DrivenArm, kinematics, reachability
from bench.fetch.scene import KINDS, STANCE, THING, Setting
from contracts.arm import ArmEnd
from contracts.geometry import Pose2D
from contracts.manipulation import FetchEnd, Holding, ManipulationState
from coordinator.manipulation import commands as do
from coordinator.manipulation import events as ev
from coordinator.manipulation.fetch import Fetch
from coordinator.manipulation.step import step
from coordinator.manipulation.transitions import Task
from grasping.candidates import TipPose
from grasping.hands import SO101_HAND
from grasping.planning import GraspPlan, Joints, PlannedGrasp, plan_grasps, way_between
from grasping.things import MeasuredThing, grasp_kind_of
from sim.world import World
from sim.world.arm.fitting import FOOT_X_M
from sim.world.arm.models import SO101

HOLD_S: Final = 2.0
"""So long it is held, raised, before it counts as held."""
HELD_GAP_M: Final = 0.008
"""A jaw that is closed further holds nothing."""
CLOSED_RAD: Final = -0.17
CARRY_AT_M: Final = (0.22, 0.0, 0.45)
"""Of the tip, in base_link: over the front of the base."""
DRIVE_M_S, DRIVE_S = 0.15, 3.0
TURN_RAD_S, TURN_S = 0.6, 2.5
GOAL: Final = Pose2D(x=1.0, y=0.0, yaw=0.0)


@dataclass(frozen=True, slots=True)
class Errors:
    """Standard deviations of what is measured of the thing, m."""

    place_m: float = 0.005
    size_m: float = 0.002


@dataclass
class FetchTruth:
    """What happened to the thing, for scoring: m and rad."""

    lifted_m: float = 0.0
    """When it had been held for `HOLD_S` after lifting."""
    slipped_m: float = 0.0
    """In the hand, meanwhile."""
    said_held: bool = False
    was_held: bool = False
    carried: bool = False
    """It was in the jaw after the robot had turned and driven."""


@dataclass
class FetchShell:
    world: World
    setting: Setting
    seed: int = 0
    errors: Errors = field(default_factory=Errors)
    watch: Callable[["FetchShell"], None] = lambda _: None
    """Called all the time; may press the stop."""

    def __post_init__(self) -> None:
        self.arm = DrivenArm(self.world, lambda: self.watch(self))
        self.chance, self.fetch, self.truth = Random(self.seed), Fetch(), FetchTruth()
        self.seen: MeasuredThing | None = None
        self.plan = GraspPlan(())
        self.finish: do.FinishFetch | None = None
        self.states: list[ManipulationState] = []
        self.stopped = False
        self._waiting: list[do.MOTION | do.ASKING] = []

    def run(self) -> do.FinishFetch:
        """One fetch, to its end."""
        self._feed(ev.FetchBegun(GOAL))
        while self._waiting and self.finish is None:
            command = self._waiting.pop(0)
            answer = self._do(command)
            if self.finish is None:
                self._feed(answer)
        if self.finish is None:
            raise RuntimeError(f"the fetch waits for nothing in {self.fetch.state}")
        return self.finish

    def stop(self) -> None:
        """The emergency stop: the controllers hold, and the core is told."""
        self.stopped = True
        self.arm.hold()
        self.world.command(0.0, 0.0)
        self._feed(ev.StopSeen(stopped=True, epoch=1))

    def thing_at(self) -> tuple[float, float, float]:
        """Truth: the middle of the thing, m."""
        x, y, z = self.world.volumes(THING)[0].centre.tolist()
        return x, y, z

    def _feed(self, event: ev.Event) -> None:
        self.fetch, commands = step(self.fetch, event, self.world.time_s)
        for one in commands:
            match one:
                case do.FinishFetch():
                    self.finish = one
                case do.TellFetchState(state=state):
                    self.states.append(state)
                case do.HaltManipulation():
                    self._waiting.clear()
                case _:
                    self._waiting.append(one)

    def _do(self, command: do.MOTION | do.ASKING) -> ev.Answer:  # noqa: PLR0911 - one line a command
        call = command.call
        match command:
            case do.FoldArm():
                return ev.ArmMoved(call, self._fold())
            case do.MoveJaw(open=opens):
                return ev.ArmMoved(call, self.arm.grip(self._open_rad() if opens else CLOSED_RAD))
            case do.MoveArm(task=task, grasp=grasp):
                return ev.ArmMoved(call, self._move(task, self.plan.grasps[grasp]))
            case do.DriveBase(carrying=carrying):
                return ev.BaseMoved(call, self._drive() if carrying else True)
            case do.PlanStance(tried=tried):
                return ev.StancePlanned(call, None if tried else STANCE)
            case do.LookAtThing():
                return ev.ThingLooked(call, self._look())
            case do.PlanGrasps():
                self.plan = self._planned()
                return ev.GraspsPlanned(call, len(self.plan.grasps), self.plan.cause)
            case do.CheckHold():
                return ev.HoldChecked(call, self._check())
            case do.AwaitHand():
                return ev.HandWaited(call, taken=True)
            case do.PlanSpot():
                return ev.SpotPlanned(call, found=False)

    # the thing

    def _look(self) -> bool:
        """The thing as it stands now, in base_link; a thing that has fallen over is not seen as one to be taken."""
        volume, pose = self.world.volumes(THING)[0], self.world.truth.pose
        if abs(float(volume.axes[2, 2])) < math.cos(0.3) and self.setting.kind != "ball":
            return False
        one, errors = KINDS[self.setting.kind], self.errors
        dx, dy = float(volume.centre[0]) - pose.x, float(volume.centre[1]) - pose.y
        cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
        place = (cos * dx + sin * dy, cos * dy - sin * dx, float(volume.centre[2]))
        x, y, z = (each + self.chance.gauss(0.0, errors.place_m) for each in place)
        wide = self.chance.gauss(0.0, errors.size_m)
        yaw = math.atan2(float(volume.axes[1, 0]), float(volume.axes[0, 0])) - pose.yaw
        self.seen = MeasuredThing(
            x, y, z, one.length_m + wide, one.width_m + wide, one.height_m, yaw if not one.round else 0.0, one.round
        )
        return True

    def _planned(self) -> GraspPlan:
        if self.seen is None:
            return GraspPlan(())
        kind = grasp_kind_of(KINDS[self.setting.kind].label, self.seen.height_m)
        return plan_grasps(self.seen, kind, SO101_HAND, FOOT_X_M, reachability(), kinematics())

    def _check(self) -> Holding:
        """As a robot can tell: the jaw is held up by something while it presses."""
        began, hand = self.thing_at(), self._thing_in_hand()
        self.arm.wait(HOLD_S)
        held = SO101_HAND.gap_at(self.arm.jaw_rad) > HELD_GAP_M
        in_hand = math.dist(hand, self._thing_in_hand()) < 0.03 and self.thing_at()[2] > self.setting.thing.z_m + 0.05
        if not self.fetch.at_goal:
            self.truth.lifted_m = min(began[2], self.thing_at()[2]) - self.setting.thing.z_m
            self.truth.slipped_m = math.dist(hand, self._thing_in_hand())
            self.truth.said_held, self.truth.was_held = held, in_hand
        else:
            self.truth.carried = in_hand
        return Holding.HELD if held else Holding.EMPTY

    def _thing_in_hand(self) -> list[float]:
        tip, pose = kinematics().tip_at(self.arm.joints), self.world.truth.pose
        x, y, z = self.thing_at()
        cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
        dx, dy = x - pose.x, y - pose.y
        return ((cos * dx + sin * dy, cos * dy - sin * dx, z) - tip.at).tolist()

    # motion

    def _open_rad(self) -> float:
        """For the grasp that was chosen; before one is, half."""
        grasps = self.plan.grasps
        return grasps[self.fetch.grasp].jaw_rad if grasps else 1.0

    def _move(self, task: Task, grasp: PlannedGrasp) -> ArmEnd:
        match task:
            case Task.MOVE_BEFORE:
                return self._go(grasp.way_in[0], self.seen)
            case Task.MOVE_TO:
                return self.arm.follow(grasp.way_in[1:])
            case Task.RAISE:
                return self.arm.follow(grasp.way_up, speed_rad_s=0.5)
            case Task.BACK_OFF:
                at = self.arm.arm.trajectory.wanted
                near = min(range(len(grasp.way_in)), key=lambda k: math.dist(grasp.way_in[k], at))
                return self.arm.follow((*grasp.way_in[near::-1], grasp.way_in[0]))
            case _:  # held out where it is carried
                return ArmEnd.COMPLETED

    def _fold(self) -> ArmEnd:
        """With something in the jaw the hand is only drawn in: folded, there is no room for a thing."""
        if self.fetch.holding is not Holding.HELD or not self.plan.grasps:
            return self._go(SO101.home, None)
        now = self.arm.arm.trajectory.wanted
        straight = (0.0, *now[1:])
        turned = kinematics().tip_at(straight)
        carried = kinematics().solve(TipPose(np.array(CARRY_AT_M), turned.approach, turned.opens), straight)
        return self.arm.follow((straight, carried) if carried is not None else (straight,), speed_rad_s=0.5)

    def _go(self, to: Joints, thing: MeasuredThing | None) -> ArmEnd:
        now = self.arm.arm.trajectory.wanted
        above = (now[0], -0.6, 0.2, 0.4, now[4]), (to[0], -0.6, 0.2, 0.4, to[4])
        way = way_between(kinematics(), now, to, self.arm.jaw_rad, thing, above)
        return self.arm.follow(way[1:]) if way is not None else ArmEnd.REJECTED

    def _drive(self) -> bool:
        """A turn and half a metre: what is carried has to stay."""
        for seconds, twist in ((TURN_S, (0.0, TURN_RAD_S)), (DRIVE_S, (DRIVE_M_S, 0.0))):
            for _ in range(round(seconds / 0.05)):
                if self.stopped:
                    return False
                self.world.command(*twist)
                self.arm.wait(0.05)
        self.world.command(0.0, 0.0)
        self.arm.wait(0.5)
        return True


def grasped(shell: FetchShell) -> bool:
    """By ground truth: raised by 0.1 m and held for `HOLD_S`."""
    return shell.truth.was_held and shell.truth.lifted_m >= 0.1


def brought(shell: FetchShell) -> bool:
    """By ground truth: in the jaw after the drive, and handed over."""
    return shell.truth.carried and shell.finish is not None and shell.finish.end is FetchEnd.DELIVERED
