"""Where to look for a thing, best place first, with the parts of each score (pure).

Two rules. CONFIDENCE is requirement A5: the memory object's views, then the label's own, each by confidence.
BELIEF multiplies what speaks for a place: that the thing is still there, that it is the one described, that it was seen
well from there and lately, and that it is not far away. Either way the robot is sent to where a thing was seen *from*,
turned to face it, never onto it.
"""

import math
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from contracts.coco import COLOURS
from contracts.geometry import Pose2D
from contracts.memory import Embedding, RecalledView, RecallRequest, RecallRule, ScoreParts
from memory.belief import LOST_BELOW, aged
from memory.kinds import kind_of
from memory.ports import Candidates, KeptView
from memory.things import Thing, remembered

SAME_DIRECTION_RAD = math.radians(60.0)
SAME_PLACE_M = 0.05
"""Nobody is sent twice to one place, whatever separation was asked for."""
AGREES, UNKNOWN, DIFFERS = 1.0, 0.6, 0.15
"""How a view's colour goes with the colours asked for; unknown: either is not known."""
RELATED = 0.4
"""A view of the memory object, where the label itself may be near."""
RECENT_S = 14.0 * 86_400.0
TRAVEL_M = 8.0
AGAIN = 0.5
"""Each further view of one thing: another thing's first view may tell more."""
LIKENESS = 0.05
"""A difference of cosines that makes a thing 2.7 times less likely to be the one described."""
SPELLINGS = {"gray": "grey", "violet": "purple"}
WORD = re.compile(r"[a-z]+")


@dataclass(frozen=True, slots=True)
class Weights:
    """Each part's power in the score; 0 leaves it out."""

    belief: float = 1.0
    agreement: float = 1.0
    relation: float = 1.0
    confidence: float = 0.5
    recency: float = 0.25
    travel: float = 0.25
    again: float = 1.0


@dataclass(slots=True)
class Scored:
    """A candidate on its way through the ranking."""

    view: KeptView
    thing: Thing | None
    source: str
    agreement: float
    parts: tuple[float, float, float, float, float, float]
    score: float
    again: float = 1.0


def rank(
    request: RecallRequest,
    of_memory_object: Candidates,
    of_label: Candidates,
    *,
    rule: RecallRule,
    weights: Weights,
    now_s: float,
) -> tuple[RecalledView, ...]:
    """Best first, no more than `request.limit`; a view close to a chosen one that looks the same way is left out."""
    things = (*of_label.things.values(), *of_memory_object.things.values())
    scoring = Scoring(request, weights, now_s, likenesses(request.embedding, things))
    groups = [("label", of_label)]
    if request.memory_object is not None and request.memory_object != request.label:
        groups.insert(0, ("memory_object", of_memory_object))
    scored = [[scoring.of(view, kept.things, source) for view in kept.views] for source, kept in groups]
    if rule is RecallRule.CONFIDENCE:
        ordered = [one for group in scored for one in _by_confidence(group, request.pose)]
    else:
        ordered = _by_score(one for group in scored for one in group if not _given_up(one))
    taken = Taken(max(request.min_separation_m, SAME_PLACE_M))
    chosen: list[RecalledView] = []
    for one in ordered:
        if len(chosen) == request.limit:
            break
        if taken.claims(one.view.x, one.view.y, one.view.yaw):
            chosen.append(scoring.told(one))
    return tuple(chosen)


def colours_in(description: str, label: str = "") -> frozenset[str]:
    """The colour words a description asks for. Of an orange, "orange" is the name unless it is said twice."""
    said: list[str] = WORD.findall(description.lower())
    words = [SPELLINGS.get(word, word) for word in said]
    if label == "orange" and words.count("orange") < 2:
        words = [word for word in words if word != "orange"]
    return frozenset(word for word in words if word in COLOURS)


@dataclass
class Scoring:
    """One request's way of weighing a view."""

    request: RecallRequest
    weights: Weights
    now_s: float
    likenesses: Mapping[int, float]
    """Of things by id, where the request and they have vectors."""
    wanted: frozenset[str] = field(init=False)
    _known: dict[int, tuple[float, float]] = field(default_factory=dict[int, tuple[float, float]])
    """Belief and agreement of things by id: alike for all their views."""

    def __post_init__(self) -> None:
        self.wanted = colours_in(self.request.description, self.request.label)

    def of(self, view: KeptView, things: dict[int, Thing], source: str) -> Scored:
        thing = things.get(view.thing_id) if view.thing_id is not None else None
        if thing is not None:
            if thing.id not in self._known:
                self._known[thing.id] = thing.belief_at(self.now_s), self._agreement(view, thing)
            belief, agreement = self._known[thing.id]
            last_seen_s = thing.last_seen_s
        else:
            belief = aged(view.belief, self.now_s - view.believed_s, kind_of(view.label).half_life_s)
            agreement = self._agreement(view, None)
            last_seen_s = view.last_seen_s
        here = self.request.pose
        travel_m = 0.0 if here is None else math.hypot(view.x - here.x, view.y - here.y)
        parts = (
            belief,
            agreement,
            1.0 if source == "label" else RELATED,
            view.confidence,
            0.5 ** (max(0.0, self.now_s - last_seen_s) / RECENT_S),
            TRAVEL_M / (TRAVEL_M + travel_m),
        )
        w = self.weights
        score = (
            parts[0] ** w.belief
            * parts[1] ** w.agreement
            * parts[2] ** w.relation
            * parts[3] ** w.confidence
            * parts[4] ** w.recency
            * parts[5] ** w.travel
        )
        return Scored(view, thing, source, agreement, parts, score)

    def told(self, one: Scored) -> RecalledView:
        belief, agreement, relation, confidence, recency, travel = one.parts
        thing = one.thing
        return RecalledView(
            view=one.view.told(),
            source=one.source,
            reason=self._reason(one),
            pose=facing(one.view, thing),
            score=min(1.0, one.score * one.again**self.weights.again),
            parts=ScoreParts(
                belief=belief,
                agreement=agreement,
                relation=relation,
                confidence=confidence,
                recency=recency,
                travel=travel,
                again=one.again,
            ),
            thing=remembered(thing, self.now_s) if thing is not None else None,
        )

    def _agreement(self, view: KeptView, thing: Thing | None) -> float:
        if thing is None:
            return self._of_colour(view.colour)
        return self.likenesses[thing.id] if thing.id in self.likenesses else self._of_colour(thing.colour or "")

    def _of_colour(self, colour: str) -> float:
        if not self.wanted:
            return AGREES
        if not colour:
            return UNKNOWN
        return AGREES if SPELLINGS.get(colour, colour) in self.wanted else DIFFERS

    def _reason(self, one: Scored) -> str:
        view, thing = one.view, one.thing
        named = f"{view.colour} {view.label}" if view.colour else view.label
        told = f"saw {named} from here with confidence {view.confidence:.2f}"
        if one.source == "memory_object":
            told = f"{told}, where {self.request.label} may be near"
        if thing is not None and thing.id in self.likenesses:
            told = f"{told}: looks {one.agreement:.0%} like the description"
        elif self.wanted:
            told = f"{told}: {_of_agreement(one.agreement)}"
        told = f"{told}; {one.parts[0]:.0%} sure it is still there"
        if thing is not None and thing.moved_from is not None:
            told = f"{told}, moved here"
        return told


def facing(view: KeptView, thing: Thing | None) -> Pose2D:
    """The view's place, turned to the thing where its own place is known."""
    if thing is None or thing.away_m(view.x, view.y) < 0.1:
        return view.pose
    return Pose2D(x=view.x, y=view.y, yaw=math.atan2(thing.y - view.y, thing.x - view.x))


class Taken:
    """Poses already chosen, in buckets as wide as the separation: each claim looks at nine of them, not at all."""

    def __init__(self, separation_m: float) -> None:
        self._separation_m = separation_m
        self._buckets: dict[tuple[int, int], list[tuple[float, float, float]]] = defaultdict(list)

    def claims(self, x: float, y: float, yaw: float) -> bool:
        """True, and the place is taken, unless a taken one is that near and looks the same way within 60 degrees."""
        column, row = math.floor(x / self._separation_m), math.floor(y / self._separation_m)
        for ox, oy, other_yaw in self._around(column, row):
            turn = abs(math.remainder(yaw - other_yaw, 2.0 * math.pi))
            if turn < SAME_DIRECTION_RAD and math.hypot(x - ox, y - oy) < self._separation_m:
                return False
        self._buckets[column, row].append((x, y, yaw))
        return True

    def _around(self, column: int, row: int) -> Iterator[tuple[float, float, float]]:
        for c in (column - 1, column, column + 1):
            for r in (row - 1, row, row + 1):
                yield from self._buckets.get((c, r), ())


def _by_confidence(group: Sequence[Scored], here: Pose2D | None) -> list[Scored]:
    """Requirement A5, with the colour asked for before an unknown one before another."""

    def key(one: Scored) -> tuple[float, float, float, int]:
        away_m = 0.0 if here is None else math.hypot(one.view.x - here.x, one.view.y - here.y)
        return -one.agreement, -one.view.confidence, away_m, one.view.id

    return sorted(group, key=key)


def _by_score(candidates: Iterable[Scored]) -> list[Scored]:
    """Each thing's best view counts in full, its further ones less and less."""

    def order(one: Scored) -> tuple[float, int]:
        return -one.score * one.again, one.view.id

    views_of: dict[int, int] = defaultdict(int)
    ordered = sorted(candidates, key=order)
    for one in ordered:
        if one.thing is not None:
            one.again = AGAIN ** views_of[one.thing.id]
            views_of[one.thing.id] += 1
    return sorted(ordered, key=order)


def _given_up(one: Scored) -> bool:
    """It was looked for and is not there; age alone does not come so far."""
    return (one.thing.belief if one.thing is not None else one.view.belief) < LOST_BELOW


def likenesses(wanted: Embedding | None, things: Iterable[Thing]) -> dict[int, float]:
    """How like the description each thing looks, by id, where both have a vector of one model.

    1 for the likest, less by how far their cosines fall behind it: models differ in what a cosine means, less in what a
    difference means.
    """
    if wanted is None:
        return {}
    cosines = {
        thing.id: sum(a * b for a, b in zip(wanted.vector, thing.embedding, strict=True))
        for thing in things
        if thing.embedding_model == wanted.model and len(thing.embedding) == len(wanted.vector)
    }
    best = max(cosines.values(), default=0.0)
    return {number: math.exp((cosine - best) / LIKENESS) for number, cosine in cosines.items()}


def _of_agreement(agreement: float) -> str:
    if agreement >= AGREES:
        return "the colour asked for"
    return "not the colour asked for" if agreement <= DIFFERS else "colour not known"
