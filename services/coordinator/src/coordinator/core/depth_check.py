"""DEPTH_CHECK: standing still, measuring how far, and asking the three votes (requirements A9 to A11)."""

from contracts.mission import EventKind, MissionState
from contracts.robot import LocalizeReply
from contracts.vision import Validation, Verdict, Vote
from coordinator.core import actions as do
from coordinator.core.activities import Looking, Measuring, Validating
from coordinator.core.centering import back_to_search
from coordinator.core.depth_consensus import agreed, sigma_m
from coordinator.core.events import DetectionsSeen, Event, Localized
from coordinator.core.events import Validated as ValidatedEvent
from coordinator.core.geometry import base_to_frame
from coordinator.core.outcomes import found, votes_data
from coordinator.core.plausibility import is_confirmed, plausible
from coordinator.core.rules import ApproachRule
from coordinator.core.sightings import follow, is_refused, lose, reject, tracked
from coordinator.core.step_context import Draft

BOX_FRESH_S = 1.5
NEXT_BOX_S = 2.0
NEAR_BOX_SHARE = 0.25


def begin(draft: Draft) -> None:
    if draft.now_s - draft.candidate.seen_s > BOX_FRESH_S:
        draft.go(MissionState.CENTERING, "the box grew old: looking again")
        return
    draft.set_candidate(samples=())
    draft.localize(draft.candidate.sighting.box)


def handle(draft: Draft, event: Event) -> None:
    match draft.mission.activity, event:
        case Measuring(), Localized(reply=reply):
            draft.set_candidate(samples=(*draft.candidate.samples, plausible(reply, draft.rules)))
            _measured(draft)
        case Looking(after_s=after_s), DetectionsSeen(detections=seen) if seen.stamp_s > after_s:
            sighting = tracked(draft.mission, draft.candidate, seen)
            if sighting is not None:
                follow(draft, sighting)
                draft.localize(sighting.box)
        case Validating(), ValidatedEvent(validation=validation):
            _validated(draft, validation)
        case _:
            pass


def on_look_timeout(draft: Draft) -> None:
    _decide(draft)


def _measured(draft: Draft) -> None:
    """Several times, and again while too few agree; what is too far to judge only once, as by the plain rule all that
    is far.
    """
    rules, samples = draft.rules, draft.candidate.samples
    first_m = samples[0].distance_m
    once_beyond_m = rules.near_m if rules.approach_rule is ApproachRule.SEEDS else rules.far_m
    if len(samples) == 1 and first_m is not None and first_m > once_beyond_m:
        _decide(draft)
        return
    _, support = agreed(samples)
    enough = len(samples) >= rules.depth_samples and (support >= rules.depth_agree or first_m is None)
    if enough or len(samples) >= rules.depth_samples_max:
        _decide(draft)
    else:
        draft.be(Looking(after_s=draft.candidate.sighting.stamp_s, until_s=draft.now_s + NEXT_BOX_S))


def take_measurement(draft: Draft, reply: LocalizeReply) -> None:
    """Keeps the place of the newest measurement that is not much worse than the best so far."""
    reply = plausible(reply, draft.rules)
    if reply.distance_m is None:
        return
    sigma, odometry = sigma_m(reply.distance_m), draft.mission.robot.odometry
    draft.set_candidate(distance_m=reply.distance_m, measured_s=draft.now_s)
    if draft.candidate.map_xy is not None and sigma > 1.5 * draft.candidate.sigma_m + 0.03:
        return
    if reply.map_point is not None:
        draft.set_candidate(map_xy=(reply.map_point.x, reply.map_point.y), sigma_m=sigma)
    if reply.base_point is not None and odometry is not None:
        draft.set_candidate(odom_xy=base_to_frame(reply.base_point, odometry))


def _decide(draft: Draft) -> None:
    """A10, with one addition in the localised rule: within reach it is validated too, where that has not been done."""
    rules = draft.rules
    reply, support = agreed(draft.candidate.samples)
    if reply is None:
        _unmeasured(draft)
        return
    take_measurement(draft, reply)
    distance = reply.distance_m or 0.0
    told = {"distance_m": round(distance, 3), "samples": len(draft.candidate.samples), "agreed": support}
    draft.say(EventKind.DEPTH, f"{distance:.2f} m away", **told, map_xy=draft.candidate.map_xy)
    if not draft.candidate.confirmed and is_refused(draft.mission, draft.candidate.map_xy, reply.distance_m):
        lose(draft)
        draft.set_search(headings=draft.search.headings[1:])  # else the next look would find it here again
        back_to_search(draft, "the same thing that was refused before")
    elif distance <= rules.reach_m and rules.approach_rule is ApproachRule.SEEDS:
        found(draft, distance, "within reach")
    elif distance > rules.far_m:
        draft.go(MissionState.DRIVING_1M, f"{distance:.1f} m is too far to judge: going closer")
    else:
        _ask(draft)


def _unmeasured(draft: Draft) -> None:
    """No depth inside the box: a big box is near enough to judge, a small one is beyond the camera's range."""
    box = draft.candidate.sighting.box
    x0, y0, x1, y1 = box.bbox_xyxy
    share = (x1 - x0) * (y1 - y0) / (box.image_width_px * box.image_height_px)
    why = draft.candidate.samples[-1].reason if draft.candidate.samples else ""
    draft.say(EventKind.DEPTH, f"no distance could be measured ({why or 'no depth in the box'})")
    if share >= NEAR_BOX_SHARE:
        _ask(draft)
    else:
        draft.go(MissionState.DRIVING_1M, "too far to measure: going closer")


def _ask(draft: Draft) -> None:
    mission, call, limit_s = draft.mission, draft.call(), draft.rules.validate_timeout_s
    assert mission.target is not None, "a running mission has a target"
    draft.act(do.Validate(call, mission.target, draft.candidate.sighting.box, limit_s))
    draft.be(Validating(call, draft.now_s + limit_s + draft.rules.call_margin_s))
    draft.set(progress=f"asking whether this is the {mission.target.description}")


def _validated(draft: Draft, validation: Validation) -> None:
    rules, candidate = draft.rules, draft.candidate
    confirmed = is_confirmed(validation, rules)
    draft.set_candidate(votes=validation.votes, confirmed=confirmed, picture=None, judged_s=draft.now_s)
    _keep_picture(draft, validation.id)
    tally = ", ".join(f"{v.voter} {v.verdict.value}" for v in validation.votes)
    word = "confirmed" if confirmed else "refused"
    draft.say(EventKind.VOTES, f"{word}: {tally}", confirmed=confirmed, votes=votes_data(validation.votes),
              picture=draft.candidate.picture)  # fmt: skip
    distance = candidate.distance_m if candidate.distance_m is not None else rules.reach_m
    if confirmed:
        if distance <= rules.reach_m:
            found(draft, candidate.distance_m, "within reach")
        elif distance <= rules.near_m:
            draft.go(MissionState.APPROACHING, f"{word} ({tally}): driving up to it")
        else:
            draft.go(MissionState.DRIVING_1M, f"{word} ({tally}): going closer first")
        return
    narrow = is_narrow(validation.votes, rules.narrow_margin) or _looked_right(draft) or by_too_few(validation.votes)
    closer = (narrow or unseen(validation.votes)) and distance > 1.2 and candidate.closer_looks < rules.closer_looks_max
    if closer and rules.approach_rule is ApproachRule.LOCALIZED:
        draft.set_candidate(closer_looks=candidate.closer_looks + 1)
        draft.go(MissionState.DRIVING_1M, f"{'narrowly ' if narrow else ''}{word} ({tally}): looking from closer once")
        return
    if unseen(validation.votes) and candidate.unseen_again < rules.unseen_again_max:
        draft.set_candidate(unseen_again=candidate.unseen_again + 1)
        draft.go(MissionState.CENTERING, f"{word} ({tally}), on a picture that did not show it: looking again")
        return
    text = f"a {_label(draft)} {distance:.1f} m off ({tally})"
    reject(draft, text, narrow=narrow)
    back_to_search(draft, f"{word} ({tally})")


def _keep_picture(draft: Draft, validation_id: str) -> None:
    """Of what was judged, for each time it was; not where inference kept none."""
    if not validation_id:
        return
    number = draft.mission.pictures
    draft.set(pictures=number + 1)
    draft.set_candidate(picture=number)
    draft.act(do.KeepPicture(number, validation_id))


def given_up_judging(draft: Draft, detail: str) -> bool:
    """True when nobody could judge this candidate in several tries: it stays in doubt, and the search goes on."""
    draft.set_candidate(unjudged=draft.candidate.unjudged + 1)
    if draft.candidate.unjudged < draft.rules.judge_tries:
        return False
    reject(draft, f"a {_label(draft)} that could not be judged ({detail})", narrow=True)
    back_to_search(draft, f"inference could not judge it in {draft.rules.judge_tries} tries")
    return True


def _looked_right(draft: Draft) -> bool:
    """A sure detector saw the colour asked for: in poor light both models that were shown the crop can be wrong."""
    sighting, colour = draft.candidate.sighting, draft.mission.colour
    return colour is not None and sighting.colour == colour and sighting.confidence >= draft.rules.sure_confidence_min


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


def _label(draft: Draft) -> str:
    return draft.mission.target.label if draft.mission.target is not None else "thing"
