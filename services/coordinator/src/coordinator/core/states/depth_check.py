"""DEPTH_CHECK: standing still, measuring how far, and asking the three votes (requirements A9 to A11)."""

from dataclasses import replace

from contracts.geometry import Pose2D
from contracts.measuring import Measurement, NotMeasured
from contracts.mission import EventFacts, EventKind, MissionState
from contracts.vision import Validation, Verdict, Vote
from coordinator.core import actions as do
from coordinator.core.activities import AwaitingFrame, Validating
from coordinator.core.depth_consensus import agreed
from coordinator.core.events import DetectionsSeen, Event
from coordinator.core.events import Validated as ValidatedEvent
from coordinator.core.evidence import Judgement, fused, of_the_same, said_by
from coordinator.core.mission import Sighting
from coordinator.core.outcomes import found, retry_or_abort
from coordinator.core.plausibility import is_confirmed
from coordinator.core.rules import ApproachRule, Rules, ValidationRule
from coordinator.core.search import back_to_search
from coordinator.core.sightings import follow, is_refused, lose, reject, tracked
from coordinator.core.states.state import State
from coordinator.core.step_context import StepContext
from geometry.poses import compose

BOX_FRESH_S = 1.5
NEXT_BOX_S = 2.0
NEAR_BOX_SHARE = 0.25


class DepthCheck(State):
    takes_unasked = False
    """Whether what lies within reach counts as found without a vote."""
    looks_closer = True
    """Whether a narrow no is looked at from closer once."""

    def doubts(self, context: StepContext) -> bool:
        """Whether what this picture refused may be the target for other reasons."""
        return _looked_right(context)

    def looks_elsewhere(self, context: StepContext, text: str) -> bool:
        """True where what was refused is looked at from another side before it is given up."""
        del context, text
        return False

    def once_beyond_m(self, rules: Rules) -> float:
        """What is farther than this is measured only once: it is too far to judge."""
        return rules.far_m

    def begin(self, context: StepContext) -> None:
        """After a failure it awaits a picture as it stands: no round of centring is spent on a service that fails."""
        if context.mission.failures == 0 and context.now_s - context.candidate.seen_s > BOX_FRESH_S:
            context.transition_to(MissionState.CENTERING, "the last detection is too old: looking again")
            return
        context.update_candidate(samples=())
        self._await_another(context)

    def handle(self, context: StepContext, event: Event) -> None:
        match context.mission.activity, event:
            case AwaitingFrame(after_s=after_s) as awaiting, DetectionsSeen(detections=seen) if seen.stamp_s > after_s:
                sighting = tracked(context.mission, context.candidate, seen)
                if sighting is not None:
                    follow(context, sighting)
                    self._take_sample(context, awaiting)
            case Validating(), ValidatedEvent(validation=validation):
                self._validated(context, validation)
            case _:
                pass

    def on_timeout(self, context: StepContext) -> None:
        match context.mission.activity:
            case _ if len(context.candidate.samples) >= context.rules.depth_samples:
                self._decide(context)
            case AwaitingFrame(unmeasured=str() as why):
                retry_or_abort(context, "robot_bridge", why)
            case _:
                context.transition_to(MissionState.CENTERING, "too few pictures measured it: looking again")

    def on_call_failed(self, context: StepContext, detail: str) -> bool:
        """A candidate that nobody could judge in several tries stays in doubt, and the search goes on."""
        if not isinstance(context.mission.activity, Validating):
            return False
        context.update_candidate(unjudged=context.candidate.unjudged + 1)
        if context.candidate.unjudged < context.rules.judge_tries:
            return False
        reject(context, f"a {label_of(context)} that could not be judged ({detail})", narrow=True)
        back_to_search(context, f"inference could not judge it in {context.rules.judge_tries} tries")
        return True

    def _await_another(self, context: StepContext) -> None:
        after_s = context.candidate.sighting.stamp_s
        context.set_activity(AwaitingFrame(after_s=after_s, until_s=context.now_s + NEXT_BOX_S))

    def _take_sample(self, context: StepContext, awaiting: AwaitingFrame) -> None:
        """Several, and more while too few agree; of what is too far to judge only one."""
        measurement, rules = context.candidate.sighting.measurement, context.rules
        if not measurement.answered:
            context.set_activity(replace(awaiting, unmeasured=measurement.text))
            return
        context.update(failures=0)
        samples = (*context.candidate.samples, measurement)
        context.update_candidate(samples=samples)
        first_m = samples[0].distance_m
        if len(samples) == 1 and first_m is not None and first_m > self.once_beyond_m(rules):
            self._decide(context)
            return
        _, support = agreed(samples)
        enough = len(samples) >= rules.depth_samples and (support >= rules.depth_agree or first_m is None)
        if enough or len(samples) >= rules.depth_samples_max:
            self._decide(context)
        else:
            self._await_another(context)

    def _decide(self, context: StepContext) -> None:
        """A10, with one addition: what lies within reach is validated too, where that has not been done."""
        rules = context.rules
        reply, _ = agreed(context.candidate.samples)
        if reply is None:
            _unmeasured(context)
            return
        take_measurement(context, reply)
        distance = reply.distance_m or 0.0
        context.log_event(EventKind.DEPTH, f"{distance:.2f} m away", EventFacts(distance_m=round(distance, 3)))
        candidate = context.candidate
        known = candidate.confirmed or candidate.revisited or candidate.other_sides > 0
        if not known and is_refused(context.mission, candidate.map_xy, reply.distance_m):
            lose(context)
            context.update_search(headings=context.search.headings[1:])  # else the next look would find it here again
            back_to_search(context, "this one was already rejected")
        elif self.takes_unasked and distance <= rules.reach_m:
            found(context, distance, "within reach")
        elif distance > rules.far_m:
            _move_closer(context, f"{distance:.1f} m is too far away to judge: moving closer")
        else:
            _ask(context)

    def _validated(self, context: StepContext, validation: Validation) -> None:
        rules, candidate = context.rules, context.candidate
        confirmed, tally = take_votes(context, validation), in_words(validation.votes)
        word = "confirmed" if confirmed else "refused"
        distance = candidate.distance_m if candidate.distance_m is not None else rules.reach_m
        if confirmed:
            if distance <= rules.reach_m:
                found(context, candidate.distance_m, "within reach")
            elif distance <= rules.near_m:
                context.transition_to(MissionState.APPROACHING, f"{word} ({tally}): driving up to it")
            else:
                _move_closer(context, f"{word} ({tally}): moving closer first")
            return
        narrow = (
            is_narrow(validation.votes, rules.narrow_margin) or self.doubts(context) or by_too_few(validation.votes)
        )
        closer = (
            (narrow or unseen(validation.votes)) and distance > 1.2 and candidate.closer_looks < rules.closer_looks_max
        )
        if closer and self.looks_closer:
            context.update_candidate(closer_looks=candidate.closer_looks + 1)
            context.transition_to(
                MissionState.DRIVING_1M, f"{'narrowly ' if narrow else ''}{word} ({tally}): taking a closer look"
            )
            return
        if unseen(validation.votes) and candidate.unseen_again < rules.unseen_again_max:
            context.update_candidate(unseen_again=candidate.unseen_again + 1)
            context.transition_to(
                MissionState.CENTERING, f"{word} ({tally}); the picture did not show it: looking again"
            )
            return
        text = f"a {label_of(context)} {distance:.1f} m off ({tally}{_evidence(context)})"
        if self.looks_elsewhere(context, text):
            return
        reject(context, text, narrow=narrow)
        back_to_search(context, f"{word} ({tally})")


def _move_closer(context: StepContext, text: str) -> None:
    """A step; all the way where the place gets better and the votes come on the way."""
    direct = context.rules.approach_rule is ApproachRule.DIRECT and context.candidate.track is not None
    context.transition_to(MissionState.APPROACHING if direct else MissionState.DRIVING_1M, text)


def _weigh(context: StepContext, validation: Validation) -> float:
    """Writes the look down; returns what all looks at this place come to, this one alone without a place."""
    said, at, here = said_by(validation.votes), context.candidate.map_xy, context.mission.robot.pose
    if at is None or here is None:
        return round(said, 2)
    judgements = (*context.search.judgements, Judgement(at, (here.x, here.y), said))[-100:]
    context.update_search(judgements=judgements)
    return round(fused(of_the_same(judgements, at, context.rules.rejected_radius_m)), 2)


def _evidence(context: StepContext) -> str:
    """How it grew, where there was more than one look."""
    grown = context.candidate.log_odds
    return f"; evidence {', '.join(f'{one:+.1f}' for one in grown)}" if len(grown) > 1 else ""


def take_votes(context: StepContext, validation: Validation) -> bool:
    """Whether they confirm it: two of three, and by evidence nothing in the other looks that speaks against it. Kept
    with the picture they were given on.
    """
    log_odds = _weigh(context, validation)
    context.update_candidate(log_odds=(*context.candidate.log_odds, log_odds)[-100:])
    by_evidence = context.rules.validation_rule is ValidationRule.EVIDENCE
    confirmed = is_confirmed(validation, context.rules) and (
        not by_evidence or log_odds >= context.rules.confirm_log_odds
    )
    context.update_candidate(votes=validation.votes, confirmed=confirmed, picture=None, judged_s=context.now_s)
    _keep_picture(context, validation.id)
    picture = context.candidate.picture
    context.log_event(
        EventKind.VOTES,
        f"{'confirmed' if confirmed else 'refused'}: {in_words(validation.votes)}",
        EventFacts(confirmed=confirmed, votes=validation.votes, log_odds=log_odds, picture=picture),
    )
    return confirmed


def in_words(votes: tuple[Vote, ...]) -> str:
    return ", ".join(f"{v.voter} {v.verdict.value}" for v in votes)


def take_measurement(context: StepContext, reply: Measurement) -> None:
    """Keeps the place of the newest measurement that is not much worse than the best so far."""
    if reply.distance_m is None:
        return
    sigma, odometry = reply.sigma_m or 0.0, context.mission.robot.odometry
    context.update_candidate(distance_m=reply.distance_m)
    if context.candidate.map_xy is not None and sigma > 1.5 * context.candidate.sigma_m + 0.03:
        return
    if reply.map_point is not None:
        context.update_candidate(map_xy=(reply.map_point.x, reply.map_point.y), sigma_m=sigma)
    if reply.base_point is not None and odometry is not None:
        there = compose(odometry, Pose2D(x=reply.base_point.x, y=reply.base_point.y, yaw=0.0))
        context.update_candidate(odom_xy=(there.x, there.y))


def _unmeasured(context: StepContext) -> None:
    """No depth inside the box: a big box is near enough to judge, a small one is beyond the camera's range."""
    why = context.candidate.samples[-1].text if context.candidate.samples else ""
    context.log_event(EventKind.DEPTH, f"no distance could be measured ({why or 'no depth in the box'})")
    if _is_big(context.candidate.sighting):
        _ask(context)
    else:
        context.transition_to(MissionState.DRIVING_1M, "too far away to measure: moving closer")


def _is_big(sighting: Sighting) -> bool:
    box = sighting.box
    x0, y0, x1, y1 = box.bbox_xyxy
    return (x1 - x0) * (y1 - y0) >= NEAR_BOX_SHARE * box.image_width_px * box.image_height_px


def is_out_of_range(sighting: Sighting) -> bool:
    """Asked about, and without a distance although it is not near."""
    measurement = sighting.measurement
    far = measurement.cause in {NotMeasured.NO_DEPTH, NotMeasured.IMPLAUSIBLE}
    return far and measurement.distance_m is None and not _is_big(sighting)


def _ask(context: StepContext) -> None:
    call = ask_votes(context, moving=False)
    limit_s = context.rules.validate_timeout_s + context.rules.call_margin_s
    context.set_activity(Validating(call, context.now_s + limit_s))


def ask_votes(context: StepContext, *, moving: bool) -> int:
    """The number of the call."""
    target, call = context.mission.target, context.call()
    assert target is not None, "a running mission has a target"
    box, limit_s = context.candidate.sighting.box, context.rules.validate_timeout_s
    context.request(do.Validate(call, target, box, limit_s, moving))
    context.update(progress=f"checking whether this is the {target.description}")
    return call


def _keep_picture(context: StepContext, validation_id: str) -> None:
    """Of what was judged, for each time it was; not where inference kept none."""
    if not validation_id:
        return
    number = context.mission.pictures
    context.update(pictures=number + 1)
    context.update_candidate(picture=number)
    context.request(do.KeepPicture(number, validation_id))


def is_no_clear_no(context: StepContext, votes: tuple[Vote, ...]) -> bool:
    return is_narrow(votes, context.rules.narrow_margin) or _looked_right(context) or by_too_few(votes)


def _looked_right(context: StepContext) -> bool:
    """A sure detector saw the colour asked for: in poor light both models that were shown the crop can be wrong."""
    sighting, colour = context.candidate.sighting, context.mission.colour
    return colour is not None and sighting.colour == colour and sighting.confidence >= context.rules.sure_confidence_min


def by_too_few(votes: tuple[Vote, ...]) -> bool:
    """True when nobody said no, but too few could say anything."""
    return not any(vote.verdict is Verdict.NO for vote in votes) and any(v.verdict is Verdict.YES for v in votes)


def unseen(votes: tuple[Vote, ...]) -> bool:
    """True when in the picture that was judged the detector saw nothing of the kind: the others judged a bad look."""
    return any(vote.voter == "detector" and vote.verdict is Verdict.NO for vote in votes)


def is_narrow(votes: tuple[Vote, ...], margin: float) -> bool:
    """True when a no was close to its threshold."""
    return any(
        v.verdict is Verdict.NO
        and v.score is not None
        and v.threshold is not None
        and v.voter != "detector"
        and v.score >= v.threshold - margin
        for v in votes
    )


def label_of(context: StepContext) -> str:
    return context.mission.target.label if context.mission.target is not None else "thing"
