"""Where to look for a thing, best place first, with the parts of each score (pure).

Two rules. CONFIDENCE is requirement A5: the memory object's views, then the label's own, each by confidence.
BELIEF multiplies what speaks for a place: that the thing is still there, that it is the one described, that it was seen
well from there and lately, and that it is not far away. Either way the robot is sent to where a thing was seen *from*,
turned to face it, never onto it.
"""

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from operator import attrgetter

from contracts.colours import COLOUR_WORDS, Colour
from contracts.geometry import Pose2D
from contracts.memory import Embedding, RecalledView, RecallRequest, RecallRule, RememberedObject, ScoreParts
from memory.belief import LOST_BELOW, aged
from memory.class_priors import kind_of
from memory.objects import MapObject, to_message
from memory.ports import Candidates, StoredView

SAME_DIRECTION_RAD = math.radians(60.0)
SAME_PLACE_M = 0.05
"""Nobody is sent twice to one place, whatever separation was asked for."""
AGREES, UNKNOWN, DIFFERS = 1.0, 0.6, 0.15
"""How a view's colour goes with the colour asked for; unknown: either is not known."""
RELATED = 0.4
"""A view of the memory object, where the label itself may be near."""
RECENT_S = 14.0 * 86_400.0
TRAVEL_M = 8.0
REPEAT_DISCOUNT = 0.5
"""Each further view of one thing: another thing's first view may tell more."""
LIKENESS = 0.05
"""A difference of cosines that makes a thing 2.7 times less likely to be the one described."""
SCORE = attrgetter("score")


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

    view: StoredView
    thing: MapObject | None
    source: str
    agreement: float
    parts: tuple[float, float, float, float, float, float]
    score: float
    again: float = 1.0


def labels_to_search(request: RecallRequest) -> dict[str, frozenset[str]]:
    """The labels whose places may be worth a look, with the spellings of the colour that a view of them should have.

    What is said of the thing's colour says nothing of the memory object's.
    """
    target = request.target
    found = {target.label: frozenset(target.colour.spellings if target.colour is not None else ())}
    if request.memory_object is not None:
        found.setdefault(request.memory_object, frozenset())
    return found


def rank(
    request: RecallRequest, found: Mapping[str, Candidates], *, rule: RecallRule, weights: Weights, now_s: float
) -> tuple[RecalledView, ...]:
    """Best first, no more than `request.limit`; a view close to a chosen one that looks the same way is left out.

    `found`: by label, of those that were `labels_to_search`.
    """
    scoring = Scoring.of(request, found[request.target.label].things.values(), weights, now_s)
    groups = [scoring.scored(found[request.target.label], "label")]
    if request.memory_object is not None and request.memory_object != request.target.label:
        groups.insert(0, scoring.scored(found[request.memory_object], "memory_object"))
    if rule is RecallRule.CONFIDENCE:
        ordered = [one for group in groups for one in _by_confidence(group, request.pose)]
    else:
        alive = (one for group in groups for one in group if not _given_up(one))
        ordered = _by_score(alive, weights.again)
    taken = PoseSeparation(max(request.min_separation_m, SAME_PLACE_M))
    chosen: list[RecalledView] = []
    for one in ordered:
        if len(chosen) == request.limit:
            break
        if taken.claim(one.view.x, one.view.y, one.view.yaw):
            chosen.append(scoring.told(one))
    return tuple(chosen)


@dataclass
class Scoring:
    """One request's way of weighing a view. What is alike for all views of a thing is worked out once."""

    request: RecallRequest
    weights: Weights
    now_s: float
    wanted: Colour | None
    likenesses: Mapping[int, float]
    """Of the label's things by id, where the request and they have vectors."""
    _told: dict[int, RememberedObject] = field(default_factory=dict[int, RememberedObject])

    @classmethod
    def of(cls, request: RecallRequest, things: Iterable[MapObject], weights: Weights, now_s: float) -> "Scoring":
        return cls(request, weights, now_s, request.target.colour, likenesses(request.embedding, things))

    def scored(self, kept: Candidates, source: str) -> list[Scored]:
        """Every view of a label, as the label's own or as the memory object's."""
        own = source == "label"
        relation = 1.0 if own else RELATED
        here, w = self.request.pose, self.weights
        of_thing = {
            thing.id: self._known(
                thing.belief_at(self.now_s), self._likeness(thing) if own else self._elsewhere, thing.last_seen_s
            )
            for thing in kept.things.values()
        }
        found: list[Scored] = []
        for view in kept.views:
            thing = kept.things.get(view.thing_id) if view.thing_id is not None else None
            if thing is not None:
                belief, agreement, recency, known = of_thing[thing.id]
            else:
                belief, agreement, recency, known = self._known(
                    aged(view.belief, self.now_s - view.believed_s, kind_of(view.label).half_life_s),
                    self._of_colour(view.colour) if own else self._elsewhere,
                    view.last_seen_s,
                )
            travel_m = 0.0 if here is None else math.hypot(view.x - here.x, view.y - here.y)
            travel = TRAVEL_M / (TRAVEL_M + travel_m)
            parts = belief, agreement, relation, view.confidence, recency, travel
            score = known * relation**w.relation * view.confidence**w.confidence * travel**w.travel
            found.append(Scored(view, thing, source, agreement, parts, score))
        return found

    def _known(self, belief: float, agreement: float, last_seen_s: float) -> tuple[float, float, float, float]:
        """Belief, agreement and recency, and what the three come to."""
        recency = 0.5 ** (max(0.0, self.now_s - last_seen_s) / RECENT_S)
        w = self.weights
        return belief, agreement, recency, belief**w.belief * agreement**w.agreement * recency**w.recency

    def told(self, one: Scored) -> RecalledView:
        belief, agreement, relation, confidence, recency, travel = one.parts
        return RecalledView(
            view=one.view.to_message(),
            source=one.source,
            reason=self._reason(one),
            pose=facing(one.view, one.thing),
            score=min(1.0, one.score),
            parts=ScoreParts(
                belief=belief,
                agreement=agreement,
                relation=relation,
                confidence=confidence,
                recency=recency,
                travel=travel,
                again=one.again,
            ),
            thing=self._remembered(one.thing) if one.thing is not None else None,
        )

    def _remembered(self, thing: MapObject) -> RememberedObject:
        if thing.id not in self._told:
            self._told[thing.id] = to_message(thing, self.now_s)
        return self._told[thing.id]

    def _likeness(self, thing: MapObject) -> float:
        return self.likenesses[thing.id] if thing.id in self.likenesses else self._of_colour(thing.colour or "")

    @property
    def _elsewhere(self) -> float:
        """Of a view of the memory object: whether what is described is there is not known."""
        return UNKNOWN if self.wanted is not None else AGREES

    def _of_colour(self, colour: str) -> float:
        if self.wanted is None:
            return AGREES
        if not colour:
            return UNKNOWN
        return AGREES if COLOUR_WORDS.get(colour) is self.wanted else DIFFERS

    def _reason(self, one: Scored) -> str:
        view, thing = one.view, one.thing
        named = f"{view.colour} {view.label}" if view.colour else view.label
        told = f"saw {named} from here with confidence {view.confidence:.2f}"
        if one.source == "memory_object":
            told = f"{told}, where {self.request.target.label} may be near"
        elif thing is not None and thing.id in self.likenesses:
            told = f"{told}: looks {one.agreement:.0%} like the description"
        elif self.wanted is not None:
            told = f"{told}: {_of_agreement(one.agreement)}"
        told = f"{told}; {one.parts[0]:.0%} sure it is still there"
        if thing is not None and thing.moved_from is not None:
            told = f"{told}, moved here"
        return told


def facing(view: StoredView, thing: MapObject | None) -> Pose2D:
    """The view's place, turned to the thing where its own place is known."""
    if thing is None or thing.away_m(view.x, view.y) < 0.1:
        return view.pose
    return Pose2D(x=view.x, y=view.y, yaw=math.atan2(thing.y - view.y, thing.x - view.x))


class PoseSeparation:
    """Poses already chosen, in buckets as wide as the separation: each claim looks at nine of them, not at all."""

    def __init__(self, separation_m: float) -> None:
        self._separation_m = separation_m
        self._buckets: dict[tuple[int, int], list[tuple[float, float, float]]] = defaultdict(list)

    def claim(self, x: float, y: float, yaw: float) -> bool:
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


def _by_score(candidates: Iterable[Scored], weight_again: float) -> list[Scored]:
    """Each thing's best view counts in full, its further ones less and less. Equals stay in order."""
    views_of: dict[int, int] = defaultdict(int)
    ordered = sorted(candidates, key=SCORE, reverse=True)
    for one in ordered:
        if one.thing is not None:
            one.again = REPEAT_DISCOUNT ** views_of[one.thing.id]
            one.score *= one.again**weight_again
            views_of[one.thing.id] += 1
    return sorted(ordered, key=SCORE, reverse=True)


def _given_up(one: Scored) -> bool:
    """It was looked for and is not there; age alone does not come so far."""
    return (one.thing.belief if one.thing is not None else one.view.belief) < LOST_BELOW


def likenesses(wanted: Embedding | None, things: Iterable[MapObject]) -> dict[int, float]:
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
