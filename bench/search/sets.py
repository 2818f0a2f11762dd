"""The sets of episodes: each number of each set is one episode, the same for every policy."""

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np

from bench.search.episode import Asked, Between, Carried, Command, Episode
from bench.search.floor import Ways
from contracts.geometry import Pose2D
from sim.home import Home, Thing
from sim.home.catalog import THINGS
from sim.home.rearrange import NoPlaceError, carried_elsewhere
from sim.scoring import camera_position, unobstructed
from sim.world import ThingTruth, World
from sim.world.occupancy import clearance_m, reachable
from sim.world.robot import ROBOT_RADIUS_M

TUNE_HOMES = tuple(range(7000, 7025))
"""For trying things out. Training has seen 100000 and up, the demo 0 to 5."""
TEST_HOMES = tuple(range(8000, 8025))
"""For reports only."""
START_CLEARANCE_M = 0.25
START_WAY_M = 2.0
LIFELONG_COMMANDS = 10
LIFELONG_MOVES = (4, 7)
SEEN_FROM_M = 2.3
DARK = {"light": 0.33, "grain": 6.0}


class Site:
    """A home of a seed, its World without cameras, and what is drawn from it."""

    def __init__(self, home_seed: int) -> None:
        self.home = Home.generate(home_seed)
        self.world = World(self.home, seed=home_seed)

    @property
    def findable(self) -> tuple[Thing, ...]:
        """Things of which the home holds no second one that fits the same words."""
        kinds = [(thing.kind, thing.colour) for thing in self.home.things]
        return tuple(
            thing for thing in self.home.things
            if THINGS[thing.kind].findable and kinds.count((thing.kind, thing.colour)) == 1
        )  # fmt: skip

    def truth_of(self, thing_id: str, world: World | None = None) -> ThingTruth:
        return next(one for one in (world or self.world).truth.things if one.id == thing_id)


@lru_cache(maxsize=2)
def site(home_seed: int) -> Site:
    return Site(home_seed)


def episode(set_name: str, number: int, homes: tuple[int, ...] = TEST_HOMES) -> Episode:
    """Episode `number` of a set. Those of one home lie `len(homes)` apart. Raises KeyError for an unknown set."""
    draw, at = SETS[set_name], site(homes[number % len(homes)])
    rng = np.random.default_rng([homes[number % len(homes)], number, list(SETS).index(set_name)])
    for _ in range(50):
        try:
            plain = draw(at, rng)
        except NoPlaceError:
            continue
        return plain.model_copy(update={"set_name": set_name, "number": number, "seed": int(rng.integers(2**31))})
    raise NoPlaceError(f"home {at.home.seed} has nothing for an episode of {set_name}")


def asked_for(thing: Thing, *, there: bool = True) -> Asked:
    return Asked(kind=thing.kind, colour=thing.colour, there=there)


def find(*asked: Asked) -> Command:
    return Command(text="find the " + ", then the ".join(one.words for one in asked), asked=asked)


def plain(at: Site, start: Pose2D, *commands: Command, tour: bool = True) -> Episode:
    return Episode(
        set_name="", number=0, seed=0, home_seed=at.home.seed, tour=tour, start=start, commands=commands,
    )  # fmt: skip


def some(at: Site, rng: np.random.Generator, count: int = 1) -> list[Thing]:
    """Things drawn without repetition."""
    things = at.findable
    if len(things) < count:
        raise NoPlaceError("too few things")
    return [things[int(k)] for k in rng.choice(len(things), count, replace=False)]


def start_in(at: Site, rng: np.random.Generator, away_from: Thing | None, world: World | None = None) -> Pose2D:
    """A place with room about it, from which there is some way to go."""
    world = world or at.world
    rows, columns = np.nonzero(reachable(world.grid, world.scene.dock, ROBOT_RADIUS_M)
                               & (clearance_m(world.grid) >= START_CLEARANCE_M))  # fmt: skip
    for _ in range(100):
        k = int(rng.integers(len(rows)))
        x, y = world.grid.centre(int(rows[k]), int(columns[k]))
        pose = Pose2D(x=round(x, 3), y=round(y, 3), yaw=round(float(rng.uniform(-math.pi, math.pi)), 3))
        if away_from is None:
            return pose
        way_m = Ways(world, pose).to_find_m(at.truth_of(away_from.id, world), 1.0)
        if START_WAY_M <= way_m < math.inf:
            return pose
    raise NoPlaceError("no place to start from")


def mapped(at: Site, rng: np.random.Generator) -> Episode:
    (thing,) = some(at, rng)
    return plain(at, start_in(at, rng, thing), find(asked_for(thing)))


def unseen(at: Site, rng: np.random.Generator) -> Episode:
    return mapped(at, rng).model_copy(update={"tour": False})


def dark(at: Site, rng: np.random.Generator) -> Episode:
    return mapped(at, rng).model_copy(update=DARK)


def moved(at: Site, rng: np.random.Generator) -> Episode:
    (thing,) = some(at, rng)
    carried = _carried(carried_elsewhere(at.home, thing.id, rng))
    world = World(carried.done_to(at.home))
    start = start_in(at, rng, thing, world)
    return plain(at, start, find(asked_for(thing))).model_copy(update={"since_tour": (carried,)})


def removed(at: Site, rng: np.random.Generator) -> Episode:
    (thing,) = some(at, rng)
    gone = Carried(thing_id=thing.id, gone=True)
    command = find(asked_for(thing, there=False))
    return plain(at, start_in(at, rng, thing), command).model_copy(update={"since_tour": (gone,)})


def distractor(at: Site, rng: np.random.Generator) -> Episode:
    """The way to one of another colour is less than 0.6 of the way to the right one."""
    pairs = [(a, b) for a in at.findable for b in at.findable if a.kind == b.kind and a.colour != b.colour]
    if not pairs:
        raise NoPlaceError("no two of a kind")
    for _ in range(40):
        right, wrong = pairs[int(rng.integers(len(pairs)))]
        start = start_in(at, rng, right)
        ways = Ways(at.world, start)
        far_m = ways.to_find_m(at.truth_of(right.id), 1.0)
        if ways.to_find_m(at.truth_of(wrong.id), 1.0) < 0.6 * far_m:
            return plain(at, start, find(asked_for(right)))
    raise NoPlaceError("none is nearer")


def occluded(at: Site, rng: np.random.Generator) -> Episode:
    """One of the three things that are seen from the least of the floor round them."""
    hidden = sorted(at.findable, key=lambda thing: _seen_share(at, thing))[:3]
    thing = hidden[int(rng.integers(len(hidden)))]
    return plain(at, start_in(at, rng, thing), find(asked_for(thing)))


def lifelong(at: Site, rng: np.random.Generator) -> Episode:
    """Ten commands; two things that are asked for later are carried elsewhere meanwhile."""
    things = some(at, rng, min(LIFELONG_COMMANDS, len(at.findable)))
    asked = [things[k % len(things)] for k in range(LIFELONG_COMMANDS)]
    between: list[Between] = []
    home = at.home
    for number in LIFELONG_MOVES:
        thing = carried_elsewhere(home, asked[number].id, rng)
        carried = _carried(thing)
        home = carried.done_to(home)
        between.append(Between(before_command=number, carried=carried))
    commands = (find(asked_for(thing)) for thing in asked)
    return plain(at, start_in(at, rng, asked[0]), *commands).model_copy(update={"between": tuple(between)})


def several(at: Site, rng: np.random.Generator) -> Episode:
    things = some(at, rng, 3)
    return plain(at, start_in(at, rng, things[0]), find(*(asked_for(thing) for thing in things)))


def absent(at: Site, rng: np.random.Generator) -> Episode:
    held = {(thing.kind, thing.colour) for thing in at.home.things}
    free = [
        Asked(kind=kind.label, colour=colour, there=False)
        for kind in THINGS.values() if kind.findable
        for colour in dict.fromkeys(kind.colours) if (kind.label, colour) not in held
    ]  # fmt: skip
    return plain(at, start_in(at, rng, None), find(free[int(rng.integers(len(free)))]))


Draw = Callable[[Site, np.random.Generator], Episode]

SETS: dict[str, Draw] = {
    "mapped": mapped, "moved": moved, "removed": removed, "distractor": distractor, "unseen": unseen,
    "occluded": occluded, "dark": dark, "lifelong": lifelong, "several": several, "absent": absent,
}  # fmt: skip


def _carried(thing: Thing) -> Carried:
    return Carried(thing_id=thing.id, x_m=thing.x_m, y_m=thing.y_m, z_m=thing.z_m, yaw=thing.yaw, support=thing.support)


def _seen_share(at: Site, thing: Thing) -> float:
    """Of the places within `SEEN_FROM_M` where a robot can stand: from how many of them nothing hides it."""
    world, truth = at.world, at.truth_of(thing.id)
    rows, columns = np.nonzero(reachable(world.grid, world.scene.dock, ROBOT_RADIUS_M))
    centres = world.grid.centres(rows, columns)
    near = centres[np.hypot(centres[:, 0] - truth.x_m, centres[:, 1] - truth.y_m) <= SEEN_FROM_M][::16]
    poses = (Pose2D(x=x, y=y, yaw=math.atan2(truth.y_m - y, truth.x_m - x)) for x, y in near.tolist())
    seen = [unobstructed(world, camera_position(pose), truth) for pose in poses]
    return sum(seen) / max(1, len(seen))
