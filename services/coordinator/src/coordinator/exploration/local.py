"""What is done without the model: to the frontiers by Nav2, a careful wander by the laser, and the way home."""

import math
from dataclasses import replace

from contracts.exploration import DecisionVerdict, ExplorationEnd, ExplorationMode, NavigateToGoal
from contracts.geometry import Pose2D
from coordinator.exploration import remembering
from coordinator.exploration.context import Context
from coordinator.exploration.decision_check import check
from coordinator.exploration.exploration import Exploration, Fallback, Standing
from coordinator.exploration.frontiers import Chart, Frontier
from coordinator.exploration.wandering import step_from
from geometry.poses import apart_m

HOME_M = 0.4
"""This near it is at home."""
TURN_AWAY_RAD = math.pi / 2
EXPLORED_M2_MIN = 1.0
"""A map that shows less room than this says nothing about what is left."""


def explore_frontiers(context: Context) -> None:
    """To the most worthwhile border that is not given up."""
    one = context.exploration
    if not isinstance(one.activity, Standing):
        return
    if one.chart is None or not one.chart.reachable.any():
        context.become(ExplorationMode.REACTIVE, "the map shows no way from here")
        return
    known = replace(context.knowledge, told=one.chart.frontiers)
    for frontier in remembering.left(one.memory, one.chart.frontiers):
        verdict = check(NavigateToGoal(frontier=frontier.number), known, one.rules.limits).verdict
        if verdict in {DecisionVerdict.NO_SCAN, DecisionVerdict.NO_POSE}:
            return
        if verdict.moves:
            context.go_to(frontier.pose, "frontier")
            return
        context.update(memory=remembering.gave_up(context.exploration.memory, frontier.pose))


def wander(context: Context) -> None:
    """The laser alone; where a frontier can be reached again, those lead."""
    one = context.exploration
    scan, pose, limits = one.surroundings, one.pose, one.rules.limits
    if not isinstance(one.activity, Standing):
        return
    if one.rules.pilot is not ExplorationMode.REACTIVE and one.chart is not None and frontiers_left(one):
        context.become(ExplorationMode.FRONTIERS, "there is a frontier that can be reached")
        explore_frontiers(context)
        return
    if scan is None or pose is None or not 0.0 <= context.now_s - scan.stamp_s <= limits.scan_age_s_max:
        return
    motion = step_from(pose, scan, one.memory.trail, one.tries, context.now_s, limits)
    if motion is None:
        context.turn(TURN_AWAY_RAD, "wander")
    else:
        context.advance(motion, "wander")


def go_home(context: Context) -> None:
    one = context.exploration
    if not isinstance(one.activity, Standing):
        return
    end = one.end or ExplorationEnd.EXPLORED
    if one.home is None or (one.pose is not None and apart_m(one.pose, one.home) <= HOME_M):
        context.finish(end, "at home")
    elif one.home_tries >= one.rules.home_tries_max:
        context.finish(ExplorationEnd.HOME_NOT_REACHED, "no way home was found")
    else:
        context.go_to(one.home, "home")


def head_home(context: Context, end: ExplorationEnd, why: str) -> None:
    context.halt()
    context.drop_question()
    context.update(end=end, silent_since_s=None, fallback=None, home_tries=0)
    context.become(ExplorationMode.RETURNING, why)


def stretch_over(context: Context) -> None:
    """One motion is over. Where the model only paused because too much of it was refused, it leads again."""
    one = context.exploration
    leads = {ExplorationMode.FRONTIERS, ExplorationMode.REACTIVE}
    if one.fallback is Fallback.REFUSED and one.mode in leads:
        context.update(fallback=None)
        context.become(ExplorationMode.MODEL, "one stretch was explored without it")


def went_to(context: Context, pose: Pose2D) -> None:
    """A goal is over, reached or not: a frontier there that is still one after some visits is given up."""
    one = context.exploration
    counts = [(at, count) for at, count in one.visits if apart_m(at, pose) > remembering.GIVEN_UP_M]
    before = sum(count for at, count in one.visits if apart_m(at, pose) <= remembering.GIVEN_UP_M)
    context.update(visits=(*counts, (pose, before + 1))[-100:])
    if before + 1 >= one.rules.visits_max:
        context.update(memory=remembering.gave_up(context.exploration.memory, pose))


def chart_seen(context: Context, chart: Chart) -> None:
    """Counts how many maps in a row leave nothing to go to."""
    memory = remembering.knows_frontiers(context.exploration.memory, chart.frontiers)
    seen = context.exploration.unknown_seen or bool(chart.frontiers)
    context.update(chart=chart, memory=memory, unknown_seen=seen)
    none = chart.reachable_m2 >= EXPLORED_M2_MIN and not frontiers_left(context.exploration)
    context.update(charts_without=context.exploration.charts_without + 1 if none else 0)


def frontiers_left(one: Exploration) -> tuple[Frontier, ...]:
    return remembering.left(one.memory, one.chart.frontiers) if one.chart is not None else ()
