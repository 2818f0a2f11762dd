"""`step(exploration, event, now_s) -> (exploration, commands)`: all that an exploration decides; pure."""

from dataclasses import replace
from typing import assert_never

from contracts.exploration import DecisionVerdict, ExplorationEnd, ExplorationMode, MoveToward
from contracts.motion import MotionEnd
from coordinator.exploration import asking, local, remembering
from coordinator.exploration import commands as do
from coordinator.exploration import events as ev
from coordinator.exploration.context import Context
from coordinator.exploration.decision_check import Advance, blocked, check
from coordinator.exploration.exploration import (
    NEVER_S,
    Advancing,
    Exploration,
    Fallback,
    Going,
    Settling,
    Standing,
    Turning,
)
from coordinator.exploration.surroundings import PlaceKind
from coordinator.exploration.watchdog import SilenceTier, tier_of

_M = ExplorationMode
LED = frozenset({_M.MODEL, _M.FRONTIERS, _M.REACTIVE})
FAILED = "failed"
OVERDUE = "timed_out"
NOT_ITS_OWN = frozenset({
    MotionEnd.PREEMPTED, MotionEnd.BASE_BUSY, MotionEnd.SESSION_ENDED, MotionEnd.CLIENT_LEFT, MotionEnd.CANCELED,
    MotionEnd.SHUT_DOWN,
})  # fmt: skip
"""Ends of a turn or a drive that say nothing of the way: somebody else ended it."""


def step(exploration: Exploration, event: ev.Event, now_s: float) -> tuple[Exploration, tuple[do.Command, ...]]:
    """What `event` at `now_s` makes of the exploration, and what is to be done about it.

    Pure: the same exploration, event and time give the same answer. Raises `ForbiddenModeError` when the core would
    leave its table (a bug, which the property tests look for).
    """
    context = Context(exploration, now_s)
    _apply(context, event)
    _go_on(context)
    return context.exploration, tuple(context.commands)


def _apply(context: Context, event: ev.Event) -> None:
    match event:
        case ev.Begun() | ev.ListenStarted() | ev.ListenEnded() | ev.ExplorationCanceled():
            _asked_by_a_person(context, event)
        case ev.RobotSeen():
            _robot_seen(context, event)
        case ev.ChartSeen(chart=chart, rooms=rooms):
            local.chart_seen(context, chart)
            if rooms:
                context.update(memory=context.exploration.memory.model_copy(update={"rooms": rooms[:50]}))
        case ev.ViewSeen(view=view):
            context.update(view=view)
        case ev.ModelAnswered() | ev.ModelFailed() | ev.LinkChanged():
            _of_the_model(context, event)
        case ev.MotionOver() | ev.GoalOver():
            _motion_ended(context, event)
        case ev.TimePassed():
            pass
        case _:
            assert_never(event)


def _of_the_model(context: Context, event: ev.ModelAnswered | ev.ModelFailed | ev.LinkChanged) -> None:
    match event:
        case ev.ModelAnswered():
            asking.answered(context, event)
        case ev.ModelFailed():
            asking.failed(context, event)
        case ev.LinkChanged(up=up):
            one = context.exploration
            silent = one.silent_since_s
            lost = not up and one.running and one.rules.pilot is _M.MODEL and one.fallback is not Fallback.SPENT
            context.update(link_up=up, silent_since_s=context.now_s if lost and silent is None else silent)


def _asked_by_a_person(
    context: Context, event: ev.Begun | ev.ListenStarted | ev.ListenEnded | ev.ExplorationCanceled
) -> None:
    match event:
        case ev.Begun():
            _begin(context, event)
        case ev.ListenStarted(for_s=for_s):
            _listen(context, for_s)
        case ev.ListenEnded():
            if context.exploration.mode is _M.LISTENING:
                context.update(listen_until_s=context.now_s)
        case ev.ExplorationCanceled():
            if context.exploration.running:
                context.finish(ExplorationEnd.CANCELED, "cancelled")


def _begin(context: Context, event: ev.Begun) -> None:
    """What is remembered of before stays, but what was given up is tried again: what stood in the way may be gone.
    Everything else begins anew. Nothing begins while it is stopped."""
    one = context.exploration
    if one.running or one.stopped:
        return
    memory = one.memory.model_copy(update={"given_up": ()})
    context.exploration = Exploration(
        rules=one.rules, home=event.home, started_s=context.now_s, begun_s=context.now_s, memory=memory,
        next_call=one.next_call, pose=one.pose, surroundings=one.surroundings, epoch=one.epoch, map_id=one.map_id,
        view=one.view, chart=one.chart, link_up=one.link_up,
        unknown_seen=one.chart is not None and bool(one.chart.frontiers),
    )  # fmt: skip
    context.become(one.rules.pilot, "begun")
    if not one.link_up and one.rules.pilot is _M.MODEL:
        context.update(silent_since_s=context.now_s)


def _robot_seen(context: Context, event: ev.RobotSeen) -> None:
    """A stop that came and went between two looks is told by its epoch."""
    known = context.exploration.epoch
    rose = known is not None and event.epoch is not None and event.epoch > known
    context.update(
        pose=event.pose, surroundings=event.surroundings, stopped=event.stopped,
        epoch=known if event.epoch is None else event.epoch,
    )  # fmt: skip
    moved = _map_seen(context, event.map_id)
    one = context.exploration
    if one.running and (event.stopped or rose):
        context.finish(ExplorationEnd.STOPPED, "the emergency stop" if event.stopped else "it came and went unseen")
        return
    if one.running and moved:
        context.finish(ExplorationEnd.ANOTHER_MAP, "the robot is in another map")
        return
    if not one.running or event.pose is None:
        return
    trail = remembering.been_at(one.memory, event.pose)
    if trail is one.memory:
        return
    context.update(memory=trail)
    scan = event.surroundings
    if scan is not None and scan.place_kind(one.rules.limits.half_width_m) is PlaceKind.DEAD_END:
        context.update(memory=remembering.dead_end_at(trail, event.pose))


def _map_seen(context: Context, map_id: str | None) -> bool:
    """Whether it is another than before; places and directions of that one mean nothing in it."""
    known = context.exploration.map_id
    if map_id is None or map_id == known:
        return False
    context.update(map_id=map_id)
    if known is None:
        return False
    context.update(chart=None, tries=(), told=())
    return True


# motion


def _motion_ended(context: Context, event: ev.MotionOver | ev.GoalOver) -> None:
    activity = context.exploration.activity
    if isinstance(event, ev.GoalOver):
        if isinstance(activity, Going) and activity.call == event.call:
            if event.outcome is ev.GoalOutcome.FAILED:
                _failed(context, activity.tool)
            else:
                _goal_over(context, activity, event.outcome.value)
        return
    if not isinstance(activity, Turning | Advancing) or activity.call != event.call:
        return
    if event.end is None or event.end in NOT_ITS_OWN:
        _failed(context, activity.tool)
        return
    if isinstance(activity, Turning) and activity.then is not None and event.end.completed:
        context.settle(activity.then, activity.tool)
        return
    if isinstance(activity, Advancing) and event.end in {MotionEnd.BLOCKED, MotionEnd.HAZARD}:
        context.update(tries=blocked(context.exploration.tries, activity.heading_rad, context.now_s))
    _over(context, activity.tool, event.end.value)


def _goal_over(context: Context, going: Going, word: str) -> None:
    """Its place was driven to, and counts as that: a frontier as visited, home as tried."""
    if context.exploration.mode is _M.RETURNING:
        context.update(home_tries=context.exploration.home_tries + 1)
    else:
        local.went_to(context, going.pose)
    _over(context, going.tool, word)


def _failed(context: Context, tool: str) -> None:
    """It was not taken, or somebody else ended it: that says nothing of the place, and it is tried again soon."""
    one = context.exploration
    context.update(
        activity=Standing(), failures=one.failures + 1, hold_until_s=context.now_s + one.rules.failed_pause_s
    )
    context.remember_action(tool, DecisionVerdict.ACCEPTED, FAILED)
    if one.failures + 1 >= one.rules.failures_max:
        context.finish(ExplorationEnd.MOTION_FAILED, f"{one.failures + 1} motions in a row failed")


def _over(context: Context, tool: str, word: str) -> None:
    context.update(activity=Standing(), failures=0, motions=context.exploration.motions + 1)
    context.remember_action(tool, DecisionVerdict.ACCEPTED, word)
    local.stretch_over(context)


def _settled(context: Context, activity: Settling) -> None:
    """Drives once a scan of after the turn says that the way is clear."""
    one = context.exploration
    scan = one.surroundings
    if scan is None or scan.stamp_s < activity.since_s:
        if context.now_s >= activity.until_s:
            context.update(activity=Standing())
            context.remember_action(activity.tool, DecisionVerdict.NO_SCAN)
            local.stretch_over(context)
        return
    ahead = MoveToward(bearing_rad=0.0, distance_m=activity.then.distance_m)
    checked = check(ahead, context.knowledge, one.rules.limits)
    context.update(tries=checked.tries, activity=Standing())
    if isinstance(checked.motion, Advance):
        speed_m_s = min(checked.motion.speed_m_s, activity.then.speed_m_s)
        context.drive(replace(checked.motion, speed_m_s=speed_m_s), activity.tool)
    else:
        if checked.verdict is DecisionVerdict.BLIND and one.pose is not None:
            context.update(tries=blocked(checked.tries, one.pose.yaw, context.now_s))  # not turned to for ever
        context.remember_action(activity.tool, checked.verdict)
        local.stretch_over(context)


# listening


def _listen(context: Context, for_s: float) -> None:
    one, now_s = context.exploration, context.now_s
    if one.mode is _M.LISTENING:
        context.update(listen_until_s=max(one.listen_until_s, now_s + for_s))
    elif one.running:
        context.halt()
        context.drop_question()
        context.update(listening_before=one.mode, listen_since_s=now_s, listen_until_s=now_s + for_s, asked=None)
        context.become(_M.LISTENING, "somebody speaks to the robot")


def _hear_out(context: Context) -> None:
    """On as before; the time it listened counts against nobody."""
    one, now_s = context.exploration, context.now_s
    if now_s < one.listen_until_s or one.listening_before is None:
        return
    held_s = now_s - one.listen_since_s
    silent = one.silent_since_s
    context.update(
        silent_since_s=silent + held_s if silent is not None else None,
        started_s=one.started_s + held_s,
        listen_until_s=NEVER_S,
        listening_before=None,
    )
    context.become(one.listening_before, "nobody says more: on as before")


# what goes on by itself


def _go_on(context: Context) -> None:
    if context.exploration.mode is _M.LISTENING:
        _hear_out(context)
    one = context.exploration
    if not one.running or one.mode is _M.LISTENING:
        return
    _overdue(context)
    if context.exploration.mode in LED:
        _watch(context)
    if isinstance(context.exploration.activity, Settling):
        _settled(context, context.exploration.activity)
    _lead(context)


def _overdue(context: Context) -> None:
    match context.exploration.activity:
        case Turning(until_s=until_s, tool=tool) | Advancing(until_s=until_s, tool=tool) if context.now_s >= until_s:
            context.halt()
            _over(context, tool, OVERDUE)
        case Going(until_s=until_s) as going if context.now_s >= until_s:
            context.halt()
            _goal_over(context, going, OVERDUE)
        case _:
            pass


def _watch(context: Context) -> None:
    """Time, what is left to explore, and the model's silence."""
    one, now_s = context.exploration, context.now_s
    if now_s - one.started_s >= one.rules.duration_s:
        local.head_home(context, ExplorationEnd.TIME_UP, f"{one.rules.duration_s:.0f} s are over")
        return
    if one.charts_without >= one.rules.charts_to_believe and one.rules.pilot is not _M.REACTIVE:
        local.head_home(context, ExplorationEnd.EXPLORED, "no frontier is left that can be reached")
        return
    if one.silent_since_s is None:
        return
    silent_s = now_s - one.silent_since_s
    match tier_of(silent_s, one.rules.watchdog):
        case SilenceTier.GO_ON:
            pass
        case SilenceTier.STAND:
            if one.mode is _M.MODEL and not isinstance(one.activity, Standing):
                context.halt()
        case SilenceTier.LOCAL:
            if one.mode is _M.MODEL:
                context.halt()
                context.become(_M.FRONTIERS, f"no answer for {silent_s:.0f} s", fallback=Fallback.SILENT)
        case SilenceTier.HOME:
            local.head_home(context, ExplorationEnd.MODEL_SILENT, f"no answer for {silent_s:.0f} s")


def _lead(context: Context) -> None:
    if context.exploration.fallback is Fallback.SILENT:
        asking.lead(context)
    if context.now_s < context.exploration.hold_until_s:
        return
    match context.exploration.mode:
        case _M.MODEL:
            asking.lead(context)
        case _M.FRONTIERS:
            local.explore_frontiers(context)
        case _M.REACTIVE:
            local.wander(context)
        case _M.RETURNING:
            local.go_home(context)
        case _M.IDLE | _M.LISTENING:
            pass
        case _:
            assert_never(context.exploration.mode)
