"""When the model is asked, and what is done of its answer (requirements C7 and C8)."""

from dataclasses import replace

from contracts.exploration import (
    AskingReason,
    CheckPathClear,
    DecisionVerdict,
    Discovery,
    ExplorationDecision,
    ExplorationMode,
    MoveToward,
    NavigateToGoal,
    ObserveScene,
    ReportDiscovery,
    StopRobot,
)
from contracts.geometry import Pose2D
from coordinator.exploration import commands as do
from coordinator.exploration import events as ev
from coordinator.exploration import local, remembering
from coordinator.exploration.context import Context
from coordinator.exploration.decision_check import Advance, Checked, GoTo, TurnBy, check
from coordinator.exploration.exploration import Asked, Exploration, Fallback, Going, OpenQuestion, Spent, Standing
from coordinator.exploration.prompt import TOLD_FRONTIERS, described
from coordinator.exploration.surroundings import PlaceKind
from coordinator.exploration.views import bits_apart
from geometry.poses import apart_m, wrap

PLACES: dict[PlaceKind, AskingReason] = {
    PlaceKind.DOORWAY: AskingReason.DOORWAY,
    PlaceKind.JUNCTION: AskingReason.JUNCTION,
    PlaceKind.DEAD_END: AskingReason.DEAD_END,
}
LOOK_ELSEWHERE_RAD = 1.0
SAME_GOAL_M = 0.5


def lead(context: Context) -> None:
    """The model leads: ask it when there is reason to, and something new to see."""
    one, now_s = context.exploration, context.now_s
    if one.question is not None:
        if now_s - one.question.asked_s > one.rules.asking.answer_s:
            context.drop_question()
        return
    if not one.link_up or now_s < one.ask_again_s:
        return
    owes_one = one.silent_since_s is not None
    reason = reason_to_ask(one, now_s) or (AskingReason.DUE if owes_one else None)
    if reason is None:
        return
    if owes_one or view_changed(one):
        ask(context, reason)
    elif isinstance(one.activity, Standing):
        look_elsewhere(context)


def reason_to_ask(one: Exploration, now_s: float) -> AskingReason | None:
    rules, asked = one.rules.asking, one.asked
    if asked is None:
        return AskingReason.BEGUN
    moved_m = apart_m(one.pose, asked.pose) if one.pose is not None and asked.pose is not None else 0.0
    if one.surroundings is not None and moved_m >= rules.place_m:
        place = one.surroundings.place_kind(one.rules.limits.half_width_m)
        if place in PLACES and place is not asked.place:
            return PLACES[place]
    if moved_m >= rules.moved_m:
        return AskingReason.MOVED
    if now_s - asked.at_s >= rules.due_s:
        return AskingReason.DUE
    return AskingReason.DONE if isinstance(one.activity, Standing) else None


def view_changed(one: Exploration) -> bool:
    """Since the model was asked last. Without a picture the robot's own way and turn say it."""
    rules, asked = one.rules.asking, one.asked
    if asked is None:
        return True
    if one.view is not None and asked.view is not None:
        return bits_apart(one.view, asked.view) > rules.view_bits
    if one.pose is None or asked.pose is None:
        return one.pose is not asked.pose
    turned = abs(wrap(one.pose.yaw - asked.pose.yaw)) >= rules.unseen_rad
    return turned or apart_m(one.pose, asked.pose) >= rules.unseen_m


def ask(context: Context, reason: AskingReason, *, answer: str = "", turns: int = 0) -> None:
    """Asks, or, where nothing is left to spend, goes on without the model."""
    one = context.exploration
    if spent_up(one):
        context.update(question=None, silent_since_s=None, fallback=Fallback.SPENT)
        if one.mode is ExplorationMode.MODEL:  # whatever stands in for it already goes on
            context.become(ExplorationMode.FRONTIERS, "nothing is left to spend on the model")
        return
    call, now_s = context.take_call(), context.now_s
    half_width_m = one.rules.limits.half_width_m
    told = remembering.left(one.memory, one.chart.frontiers)[:TOLD_FRONTIERS] if one.chart is not None else ()
    place = one.surroundings.place_kind(half_width_m) if one.surroundings is not None else PlaceKind.ROOM
    since_s = one.silent_since_s
    context.update(
        question=OpenQuestion(call, now_s, turns),
        asked=Asked(now_s, one.pose, one.view, place, reason),
        silent_since_s=now_s if since_s is None else since_s,
        told=told,
        looked_elsewhere=0,
        spent=_asked_once_more(one.spent, reason),
    )
    situation = described(one.memory, one.pose, one.surroundings, told, half_width_m)
    context.tell(do.AskModel(call, reason, situation, answer))


def spent_up(one: Exploration) -> bool:
    limits, spent = one.rules.spending, one.spent
    return spent.calls >= limits.calls_max or spent.tokens >= limits.tokens_max or spent.seconds >= limits.seconds_max


def look_elsewhere(context: Context) -> None:
    """The view has not changed, and it is not asked about twice: the robot turns by itself to see something new."""
    one = context.exploration
    scan = one.surroundings
    if one.looked_elsewhere >= one.rules.asking.unchanged_max:
        context.update(looked_elsewhere=0, fallback=Fallback.REFUSED)
        context.become(ExplorationMode.FRONTIERS, "the view does not change")
        return
    if scan is None or not 0.0 <= context.now_s - scan.stamp_s <= one.rules.limits.scan_age_s_max:
        return
    context.update(looked_elsewhere=one.looked_elsewhere + 1)
    context.turn(LOOK_ELSEWHERE_RAD, "look_elsewhere")


# answers


def failed(context: Context, event: ev.ModelFailed) -> None:
    question = context.exploration.question
    if question is None or question.call != event.call:
        _late(context, event.call, 0)
        return
    again_s = context.now_s + context.exploration.rules.asking.again_s
    context.update(question=None, ask_again_s=again_s, spent=_waited(context.exploration, question, context.now_s, 0))


def answered(context: Context, event: ev.ModelAnswered) -> None:
    """An answer to the question that is open; every other is dropped unread, and what it cost is counted."""
    one = context.exploration
    question = one.question
    if question is None or question.call != event.call:
        _late(context, event.call, event.tokens)
        return
    spent = _waited(one, question, context.now_s, event.tokens)
    context.update(question=None, silent_since_s=None, spent=spent)
    if one.mode in {ExplorationMode.FRONTIERS, ExplorationMode.REACTIVE} and one.fallback is Fallback.SILENT:
        context.halt()
        context.become(ExplorationMode.MODEL, "the model answers again", fallback=None)
    if context.exploration.mode is not ExplorationMode.MODEL:
        return
    if event.decision is None:
        refused(context, "unknown", DecisionVerdict.NOT_UNDERSTOOD)
        return
    asked_at = one.asked.pose if one.asked is not None else None
    decision = as_of_now(event.decision, asked_at, one.pose)
    checked = check(decision, context.knowledge, one.rules.limits)
    context.update(tries=checked.tries)
    if checked.motion is not None and context.now_s < one.hold_until_s:
        return  # it is asked again once the robot takes motions again
    if not checked.verdict.moves and not isinstance(decision, CheckPathClear):
        if isinstance(decision, NavigateToGoal) and checked.verdict is DecisionVerdict.GOAL_NOT_FREE:
            _count_frontier(context, decision.frontier)
        refused(context, decision.tool, checked.verdict)
        return
    context.count(checked.verdict)
    _carry_out(context, decision, checked, question.turns)


def _late(context: Context, call: int, tokens: int) -> None:
    one = context.exploration
    if call in one.dropped:
        spent = replace(one.spent, tokens=one.spent.tokens + max(0, tokens))
        context.update(dropped=tuple(each for each in one.dropped if each != call), spent=spent)


def _count_frontier(context: Context, number: int | None) -> None:
    """A frontier that there is no room at counts as driven to: it is not told for ever."""
    for one in context.exploration.told:
        if one.number == number:
            local.went_to(context, one.pose)


def as_of_now(decision: ExplorationDecision, asked_at: Pose2D | None, pose: Pose2D | None) -> ExplorationDecision:
    """A bearing was meant from where the robot headed when it asked; it has turned since."""
    if not isinstance(decision, MoveToward | CheckPathClear) or asked_at is None or pose is None:
        return decision
    return decision.model_copy(update={"bearing_rad": wrap(asked_at.yaw + decision.bearing_rad - pose.yaw)})


def refused(context: Context, tool: str, verdict: DecisionVerdict) -> None:
    """Nothing of it is done. After a few in a row one stretch is explored without the model."""
    context.count(verdict)
    context.remember_action(tool, verdict)
    refusals = context.exploration.refusals + 1
    context.update(refusals=refusals)
    if refusals >= context.exploration.rules.asking.refusals_max:
        context.halt()
        context.update(refusals=0, fallback=Fallback.REFUSED)
        context.become(ExplorationMode.FRONTIERS, f"{refusals} decisions in a row were refused")


def _carry_out(context: Context, decision: ExplorationDecision, checked: Checked, turns: int) -> None:
    match decision:
        case ObserveScene():
            _tell(context, decision.tool, turns, "look at the picture and at what is clear")
        case CheckPathClear():
            clear_m = checked.clear_m
            way = "nothing in reach" if clear_m is None else f"clear for {min(clear_m, 12.0):.1f} m"
            word = "yes" if checked.verdict.moves else checked.verdict.value
            _tell(context, decision.tool, turns, f"{word}, {way}")
        case ReportDiscovery(label=label, note=note):
            pose = context.exploration.pose
            if pose is not None:
                found = Discovery(label=label, note=note, x_m=pose.x, y_m=pose.y, stamp_s=max(0.0, context.now_s))
                context.update(memory=remembering.found(context.exploration.memory, found))
            context.remember_action(decision.tool, checked.verdict)
            _tell(context, decision.tool, turns, "written down")
        case StopRobot():
            context.halt()
            context.update(refusals=0)
            context.remember_action(decision.tool, checked.verdict)
        case _:
            context.update(refusals=0)
            _move(context, decision, checked)


def _move(context: Context, decision: ExplorationDecision, checked: Checked) -> None:
    activity, motion = context.exploration.activity, checked.motion
    if isinstance(motion, GoTo) and isinstance(activity, Going) and apart_m(activity.pose, motion.pose) <= SAME_GOAL_M:
        return  # it is on its way there
    context.halt()
    match motion:
        case TurnBy(angle_rad=angle_rad):
            context.turn(angle_rad, decision.tool)
        case Advance():
            context.advance(motion, decision.tool)
        case GoTo(pose=pose):
            context.go_to(pose, decision.tool)
        case None:
            raise AssertionError(f"an accepted {decision.tool} has a motion")


def _tell(context: Context, tool: str, turns: int, answer: str) -> None:
    """The question goes on; not for ever."""
    if turns + 1 > context.exploration.rules.asking.tool_turns_max:
        refused(context, tool, DecisionVerdict.TRIED_TOO_OFTEN)
        return
    ask(context, AskingReason.TOOL_ANSWERED, answer=answer, turns=turns + 1)


def _asked_once_more(spent: Spent, reason: AskingReason) -> Spent:
    counts = dict(spent.by_reason)
    counts[reason] = counts.get(reason, 0) + 1
    return replace(spent, calls=spent.calls + 1, by_reason=tuple(counts.items()))


def _waited(one: Exploration, question: OpenQuestion, now_s: float, tokens: int) -> Spent:
    seconds = one.spent.seconds + max(0.0, now_s - question.asked_s)
    return replace(one.spent, tokens=one.spent.tokens + max(0, tokens), seconds=seconds)
