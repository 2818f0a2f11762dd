"""A thing at a place, and which thing a sighting is of (pure).

Identity comes from position and from being in one frame together, never from the label alone: two boxes of one frame
are two things, however alike; a box nearer to a known thing than its kind's radius is that thing seen again.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from contracts.geometry import Point3D, Pose2D
from contracts.memory import ObjectState, Observation, RememberedObject
from memory.belief import FIRST, LOST_BELOW, after_sighting, aged, state_of
from memory.class_priors import kind_of

LOCALISED_M_MAX = 3.0
"""Depth farther away than this is noise (requirement A9)."""
POSE_SIGMA_M = 0.06
UNKNOWN_SIGMA_M = 0.1
"""Of a place that comes without its own."""
SIGMA_MIN_M = 0.03
DRIFT_M = 0.02
"""Added before each sighting, so that a thing follows a map that drifts."""
GATE_M_MAX = 0.5
"""The most that uncertainty adds to a kind's radius."""
OTHER_COLOUR = 0.6
"""Of the gate: a sighting of another colour must be this much nearer to be the same thing. Colour words err too."""
COLOUR_FADES = 0.9
EMBEDDING_FADES = 0.8


@dataclass(frozen=True, slots=True)
class MapObject:
    """`id` below zero: not stored yet. `belief` is as of `believed_s`. `colours`: faded votes by colour word."""

    id: int
    label: str
    x: float
    y: float
    z: float
    variance_m2: float
    belief: float
    believed_s: float
    confidence: float
    first_seen_s: float
    last_seen_s: float
    times_seen: int = 1
    colours: Mapping[str, float] = field(default_factory=dict[str, float])
    times_missed: int = 0
    last_missed_s: float | None = None
    miss_x: float = 0.0
    miss_y: float = 0.0
    miss_loss: float = 1.0
    moved_from: int | None = None
    moved_to: int | None = None
    map_number: int = 0
    """Of the map that its place is in."""
    embedding_model: str = ""
    embedding: tuple[float, ...] = ()

    @property
    def colour(self) -> str | None:
        return max(self.colours, key=lambda word: self.colours[word], default=None)

    @property
    def lost(self) -> bool:
        return self.belief < LOST_BELOW

    def belief_at(self, now_s: float) -> float:
        return aged(self.belief, now_s - self.believed_s, kind_of(self.label).half_life_s)

    def state_at(self, now_s: float) -> ObjectState:
        return state_of(self.belief, self.belief_at(now_s), moved=self.moved_to is not None)

    def away_m(self, x: float, y: float) -> float:
        return math.hypot(self.x - x, self.y - y)


def to_message(thing: MapObject, now_s: float) -> RememberedObject:
    """As others are told of it."""
    return RememberedObject(
        id=thing.id,
        label=thing.label,
        colour=thing.colour,
        description=f"{thing.colour} {thing.label}" if thing.colour else thing.label,
        position=Point3D(x=thing.x, y=thing.y, z=thing.z),
        uncertainty_m=math.sqrt(thing.variance_m2),
        belief=thing.belief_at(now_s),
        state=thing.state_at(now_s),
        confidence=thing.confidence,
        first_seen_s=thing.first_seen_s,
        last_seen_s=thing.last_seen_s,
        last_missed_s=thing.last_missed_s,
        times_seen=thing.times_seen,
        times_missed=thing.times_missed,
        moved_from=thing.moved_from,
        moved_to=thing.moved_to,
    )


def usable_position(observation: Observation) -> Point3D | None:
    """Where the thing is, unless it was too far away to tell."""
    position = observation.position
    if position is None or _distance_m(observation.pose, position) > LOCALISED_M_MAX:
        return None
    return position


def matches(seen: Sequence[Observation], things: Sequence[MapObject]) -> list[MapObject | None]:
    """For each observation of one frame the known thing it shows, or none. No thing is given twice.

    All observations have a usable position. Nearest first, in units of the kind's gate; another colour is a handicap.
    """
    pairs = [
        (cost, index, thing)
        for index, one in enumerate(seen)
        for thing in _near(one, things)
        if (cost := _cost(one, thing)) <= 1.0
    ]
    pairs.sort(key=lambda pair: (pair[0], pair[1], pair[2].id))
    found: list[MapObject | None] = [None] * len(seen)
    taken: set[int] = set()
    for _, index, thing in pairs:
        if found[index] is None and thing.id not in taken:
            found[index] = thing
            taken.add(thing.id)
    return found


def first_seen(observation: Observation, position: Point3D, number: int) -> MapObject:
    """A thing never seen before; `number` is below zero until the store has given it an id."""
    return MapObject(
        id=number,
        label=observation.label,
        x=position.x,
        y=position.y,
        z=position.z,
        variance_m2=_variance_m2(observation),
        belief=after_sighting(FIRST, observation.confidence),
        believed_s=observation.stamp_s,
        confidence=observation.confidence,
        first_seen_s=observation.stamp_s,
        last_seen_s=observation.stamp_s,
        colours={observation.colour: 1.0} if observation.colour else {},
        embedding_model=observation.embedding.model if observation.embedding else "",
        embedding=_unit(observation.embedding.vector) if observation.embedding else (),
    )


def seen_again(thing: MapObject, observation: Observation, position: Point3D | None) -> MapObject:
    """The thing after one more sighting; without a position its own stays as it was.

    What was lost and is seen again is as sure as what is seen for the first time.
    """
    known = thing if position is None else _moved_towards(thing, observation, position)
    stamp_s = max(known.believed_s, observation.stamp_s)
    return replace(
        _embedded(known, observation),
        belief=after_sighting(max(FIRST, known.belief_at(observation.stamp_s)), observation.confidence),
        believed_s=stamp_s,
        confidence=max(known.confidence, observation.confidence),
        first_seen_s=min(known.first_seen_s, observation.stamp_s),
        last_seen_s=max(known.last_seen_s, observation.stamp_s),
        times_seen=known.times_seen + 1,
        colours=_voted(known.colours, observation.colour),
        miss_loss=1.0,
        moved_to=None,
    )


def could_be_the_same(one: MapObject, other: MapObject) -> bool:
    """By what they look like: same label, and no two known colours that differ."""
    return one.label == other.label and (one.colour == other.colour or None in {one.colour, other.colour})


def _near(observation: Observation, things: Sequence[MapObject]) -> list[MapObject]:
    """A quick sieve: most things of a label are in other rooms."""
    position = observation.position
    if position is None:
        return []
    reach_m = kind_of(observation.label).radius_m + GATE_M_MAX
    west, east = position.x - reach_m, position.x + reach_m
    south, north = position.y - reach_m, position.y + reach_m
    return [one for one in things if west < one.x < east and south < one.y < north]


def _cost(observation: Observation, thing: MapObject) -> float:
    position = observation.position
    if position is None or observation.label != thing.label:
        return math.inf
    away_m = thing.away_m(position.x, position.y)
    radius_m = kind_of(thing.label).radius_m
    if away_m > radius_m + GATE_M_MAX:
        return math.inf
    sigma_m = math.sqrt(thing.variance_m2 + _variance_m2(observation))
    gate_m = radius_m + min(GATE_M_MAX, max(0.0, 2.0 * sigma_m - radius_m))
    handicap = (
        OTHER_COLOUR if None not in {observation.colour, thing.colour} and (observation.colour != thing.colour) else 0.0
    )
    return away_m / gate_m + handicap


def _moved_towards(thing: MapObject, observation: Observation, position: Point3D) -> MapObject:
    """A scalar Kalman step: the surer of the two counts more."""
    before = thing.variance_m2 + DRIFT_M**2
    new = _variance_m2(observation)
    gain = before / (before + new)
    return replace(
        thing,
        x=thing.x + gain * (position.x - thing.x),
        y=thing.y + gain * (position.y - thing.y),
        z=thing.z + gain * (position.z - thing.z),
        variance_m2=max(SIGMA_MIN_M**2, before * (1.0 - gain)),
    )


def _variance_m2(observation: Observation) -> float:
    """Of the place: the measurement's, and the robot's own pose."""
    sigma_m = observation.sigma_m if observation.sigma_m is not None else UNKNOWN_SIGMA_M
    return sigma_m**2 + POSE_SIGMA_M**2


def _distance_m(pose: Pose2D, position: Point3D) -> float:
    return math.hypot(position.x - pose.x, position.y - pose.y)


def _voted(colours: Mapping[str, float], colour: str | None) -> Mapping[str, float]:
    """Older votes fade, so that a green cup in the red one's place is green before long."""
    if not colour:
        return colours
    faded = {word: votes * COLOUR_FADES for word, votes in colours.items() if votes > 0.05}
    faded[colour] = faded.get(colour, 0.0) + 1.0
    return faded


def _embedded(thing: MapObject, observation: Observation) -> MapObject:
    """A new model's vector replaces the old one's; vectors of one model are mixed."""
    new = observation.embedding
    if new is None:
        return thing
    vector = _unit(new.vector)
    if new.model == thing.embedding_model and len(vector) == len(thing.embedding):
        pairs = zip(thing.embedding, vector, strict=True)
        vector = _unit([EMBEDDING_FADES * old + (1.0 - EMBEDDING_FADES) * one for old, one in pairs])
    return replace(thing, embedding_model=new.model, embedding=vector)


def _unit(vector: Sequence[float]) -> tuple[float, ...]:
    length = math.sqrt(sum(one * one for one in vector)) or 1.0
    return tuple(one / length for one in vector)
