"""CENTERING: turning until the target is in the middle of the picture (requirement A8)."""

import math
from collections.abc import Callable

from contracts.mission import MissionState
from contracts.vision import Detections
from coordinator.core.activities import AwaitingFrame, Rotating
from coordinator.core.events import DetectionsSeen, Event, MotionEnded
from coordinator.core.mission import Sighting
from coordinator.core.reactions import Reaction, react
from coordinator.core.search import back_to_search
from coordinator.core.sightings import bearing_error_rad, colour_in_its_place, follow, lose, reject, tracked
from coordinator.core.states.state import State
from coordinator.core.step_context import StepContext

TURN_SPEED_RAD_S = 0.8

Turn = Callable[[StepContext, Sighting], None]
"""How it turns to what it saw, and then looks again."""


class Centering(State):
    def __init__(self, turn: Turn, *, finishes_unseen: bool) -> None:
        """`finishes_unseen`: what is confirmed and localised is driven up to though it left the picture."""
        self.turn, self.finishes_unseen = turn, finishes_unseen

    def begin(self, context: StepContext) -> None:
        candidate = context.candidate
        if candidate.rounds >= context.rules.rounds_max:
            why = f"a {_what(context)} that could not be reached in {candidate.rounds} rounds"
            reject(context, why, narrow=True)
            back_to_search(context, why)
            return
        context.update_candidate(
            since_s=context.now_s, seen_s=context.now_s, centered=0, rounds=candidate.rounds + 1, samples=(),
        )  # fmt: skip
        context.look(context.rules.centering_lost_s)

    def handle(self, context: StepContext, event: Event) -> None:
        match context.mission.activity, event:
            case AwaitingFrame(after_s=after_s), DetectionsSeen(detections=seen) if seen.stamp_s >= after_s:
                self._seen(context, seen)
            case Rotating(), MotionEnded() as ended:
                if react(context, ended) is Reaction.GO_ON:
                    await_newer_frame(context)
            case _:
                pass

    def on_timeout(self, context: StepContext) -> None:
        """Lost for 4 s, or not centred in 15 s. What is confirmed and localised is finished on the map."""
        candidate = context.candidate
        if candidate.confirmed and candidate.map_xy is not None and self.finishes_unseen:
            context.transition_to(MissionState.APPROACHING, "out of view from here: driving to its measured position")
            return
        lost = context.now_s - candidate.seen_s >= context.rules.centering_lost_s
        lose(context)
        what = _what(context)
        back_to_search(context, f"lost sight of the {what}" if lost else f"the {what} could not be centred")

    def _seen(self, context: StepContext, seen: Detections) -> None:
        rules = context.rules
        if context.now_s - context.candidate.since_s > rules.centering_timeout_s:
            context.stop_motion()
            self.on_timeout(context)
            return
        other = other_colour(context, seen)
        if other:
            leave_for_its_colour(context, other)
            return
        sighting = tracked(context.mission, context.candidate, seen)
        if sighting is None:
            context.update_candidate(centered=0)
            await_newer_frame(context, after_s=seen.stamp_s)
            return
        follow(context, sighting)
        if abs(sighting.error_px) <= rules.centering_tolerance_px:
            context.update_candidate(centered=context.candidate.centered + 1)
            if context.candidate.centered >= rules.centering_detections:
                context.transition_to(MissionState.DEPTH_CHECK, "centred: measuring the distance")
            else:
                await_newer_frame(context, after_s=seen.stamp_s)
            return
        context.update_candidate(centered=0)
        self.turn(context, sighting)


def other_colour(context: StepContext, seen: Detections) -> str:
    """The colour it has after all, once enough pictures have named it; empty until then."""
    asked, named = context.mission.colour, colour_in_its_place(context.mission, context.candidate, seen)
    if asked is None or named is None:
        return ""
    count = context.candidate.other_colour + (1 if named != asked else -1)
    context.update_candidate(other_colour=max(0, count))
    return named if count >= context.rules.other_colour_looks else ""


def leave_for_its_colour(context: StepContext, other: str) -> None:
    context.stop_motion()
    lose(context)
    back_to_search(context, f"it is {other}, not {context.mission.colour}")


def bearing_turn(context: StepContext, sighting: Sighting) -> None:
    """One turn by the angle at which it was seen."""
    context.turn(bearing_error_rad(context.mission, sighting), TURN_SPEED_RAD_S)


def await_newer_frame(context: StepContext, *, after_s: float | None = None) -> None:
    """Waits for a newer frame, no longer than until the target counts as lost or the time is up."""
    rules, candidate = context.rules, context.candidate
    until_s = min(candidate.seen_s + rules.centering_lost_s, candidate.since_s + rules.centering_timeout_s)
    after = context.robot_now_s + rules.look_settle_s if after_s is None else math.nextafter(after_s, math.inf)
    context.set_activity(AwaitingFrame(after_s=after, until_s=max(until_s, context.now_s)))


def _what(context: StepContext) -> str:
    return context.mission.target.description if context.mission.target is not None else "target"
