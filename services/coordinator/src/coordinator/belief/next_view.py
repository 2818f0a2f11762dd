"""Where to look next: the place, and how much of a turn there, by which the target is found soonest.

A view is worth its probability of showing the target, and costs the seconds of the way, the turns and the looks. The
few views with most probability a second are each played on (greedily, a few views far); the one whose play is expected
to find the target soonest is taken. The search ends when no view is worth its seconds any more.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contracts.geometry import Pose2D
from contracts.mission import MapTrouble
from coordinator.belief.belief_map import RAYS, BeliefMap, sides_of
from coordinator.belief.detection_probability import by_distance
from coordinator.coverage.lawnmower import trouble_of
from coordinator.coverage.viewpoints import candidate_cells, walks_m
from coordinator.coverage.visibility import VisibilityIndex
from geometry.poses import wrap

BINS = 72
BIN_RAD = 2 * math.pi / BINS
PLACES_MAX = 240
"""Of a large map the places that promise most a second are compared."""
PLAYED, STEPS = 6, 5
TAIL_S = 45.0
"""What is not found at the end of a play is taken to be found so much later."""
WORTH_S = 2000.0
"""A find is worth so long a search: a view with less than 1/2000 a second is not driven to."""
HERE_MIN = 0.03
NEAR_M = 3.0
"""A clue so near is told as the reason."""


@dataclass(frozen=True, slots=True)
class MotionTimes:
    """How long moving and looking takes. The defaults are what `bench.search` showed (30 November, homes `tune`): 1.6 s
    a look of a sweep, and 3 to 5 s of each drive beside its metres.
    """

    speed_m_s: float
    turn_rad_s: float
    hfov_rad: float
    step_rad: float
    look_s: float = 0.5
    turn_s: float = 0.4
    """Beside the turning itself: to begin and to end it."""
    choice_s: float = 1.5
    """Of each view, to be chosen and begun."""
    drive_s: float = 4.0
    """The same of a drive: planning, turning there, settling."""


@dataclass(frozen=True, slots=True)
class NextView:
    """Stand there, and look in these directions of the map frame, one after another."""

    pose: Pose2D
    headings: tuple[float, ...]
    gain: float
    seconds: float
    metres: float


@dataclass(frozen=True, slots=True)
class Choice:
    """None where nothing is worth it any more; `here` is how probably the target is on this map."""

    view: NextView | None
    here: float
    why: str
    trouble: MapTrouble | None = None
    """A map to search nothing on, as a plan of coverage tells it."""


@dataclass(frozen=True, slots=True)
class _Option:
    place: int
    first_bin: int
    looks: int
    gain: float
    seconds: float


def next_view(
    belief: BeliefMap, here: Pose2D, pace: MotionTimes, *, avoid: tuple[Pose2D, ...] = (), avoid_m: float = 0.35
) -> Choice:
    """The same belief, place and pace give the same choice."""
    trouble = trouble_of(belief.grid, fits=bool(belief.coarse.passable.any()))
    if trouble is not None:
        return Choice(None, 1.0 - belief.absent, "", trouble)
    return _Views(belief, here, pace, avoid, avoid_m).choice()


class _Views:
    """All views of one belief from where the robot stands; place 0 is that place, and no other lies within `avoid_m`:
    the robot would not drive to it, and look from where it is.
    """

    def __init__(
        self, belief: BeliefMap, here: Pose2D, pace: MotionTimes, avoid: tuple[Pose2D, ...], avoid_m: float
    ) -> None:
        self._belief, self._pace, self._here = belief, pace, here
        coarse, reach = belief.coarse, belief.reach
        start = belief.cell(here) or (0, 0)
        lattice = candidate_cells(belief.grid, coarse, (*avoid, here), avoid_m)
        self._walks: dict[int, NDArray[np.float64]] = {}
        index = VisibilityIndex(coarse.blocked, np.vstack([[start], lattice]), reach, rays=RAYS, edges=True)
        rows, columns = index.around
        turned = (np.arctan2(rows, columns) + belief.grid.origin.yaw) % (2 * math.pi)
        bins = np.minimum((turned / BIN_RAD).astype(np.intp), BINS - 1)
        padded = np.pad(belief.cells, reach)
        self._mass = padded.ravel()
        self._doubt = np.pad(belief.looked, ((0, 0), (reach, reach), (reach, reach))).ravel()
        self._places = np.vstack([[start], lattice])
        meant = belief.looked_from[tuple(self._places.T)]
        meant |= not meant.any()  # a room in which the robot fits nowhere is looked into from outside
        place, disc = np.nonzero(index.seen & (self._mass[index.cells] > 0.0) & meant[:, None])
        chance = by_distance(belief.label, np.hypot(rows, columns) * coarse.resolution_m)
        self._place, self._bin = place, bins[disc]
        """Of each cell that a place sees: which place, in which direction, which cell and from which side, and how
        probably a look shows it."""
        self._cell = index.cells[place, disc]
        self._side = self._cell + sides_of(rows, columns)[disc] * padded.size
        self._chance = chance[disc]
        self._keep_the_best()

    def _keep_the_best(self) -> None:
        if len(self._places) <= PLACES_MAX:
            return
        gains = self._gains(self._mass, self._doubt).sum(axis=1)
        rate = gains / (self._travel_s(0) + self._pace.look_s)
        rate[0] = np.inf
        kept = np.sort(np.argsort(-rate, kind="stable")[:PLACES_MAX])
        number = np.full(len(self._places), -1, dtype=np.intp)
        number[kept] = np.arange(len(kept))
        mine = number[self._place] >= 0
        self._place = number[self._place[mine]]
        self._bin, self._cell = self._bin[mine], self._cell[mine]
        self._side, self._chance = self._side[mine], self._chance[mine]
        self._places = self._places[kept]
        self._walks.clear()

    def choice(self) -> Choice:
        here = 1.0 - self._belief.absent
        options = self._options(0, self._here.yaw, self._mass, self._doubt)
        worth = [one for one in options if one.gain * WORTH_S >= one.seconds]
        if not worth or here < HERE_MIN:
            return Choice(None, here, f"what is left is not worth a look: {1 - here:.0%} sure that it is not here")
        best = min(worth[:PLAYED], key=lambda one: (self._expected_s(one, here), -one.gain / one.seconds))
        view = self._view(best)
        return Choice(view, here, self._sentence(view, here))

    def _options(self, at: int, yaw: float, mass: NDArray[np.float64], doubt: NDArray[np.float64]) -> list[_Option]:
        """The best view of each place, by probability a second, best first."""
        pace, gains = self._pace, self._gains(mass, doubt)
        travel_s = self._travel_s(at)
        before = np.concatenate([np.zeros((len(gains), 1)), np.cumsum(np.hstack([gains, gains]), axis=1)], axis=1)
        best_rate = np.zeros(len(gains))
        best = np.zeros((len(gains), 2), dtype=np.intp)
        best_gain, best_s = np.zeros(len(gains)), np.ones(len(gains))
        for looks in range(1, math.ceil((2 * math.pi) / pace.step_rad) + 1):
            across = min(BINS, int((pace.hfov_rad + (looks - 1) * pace.step_rad) / BIN_RAD))
            gain = before[:, across : across + BINS] - before[:, :BINS]
            sweep_s = (
                pace.choice_s + looks * pace.look_s + (looks - 1) * (pace.step_rad / pace.turn_rad_s + pace.turn_s)
            )
            seconds = np.full(gain.shape, sweep_s) + travel_s[:, None]
            turns = self._first_turn_rad(yaw, looks, across)
            seconds[at] += turns / pace.turn_rad_s + np.where(turns > 0.06, pace.turn_s, 0.0)
            rate = gain / seconds
            first = np.argmax(rate, axis=1)
            rows = np.arange(len(gains))
            better = rate[rows, first] > best_rate
            best_rate = np.where(better, rate[rows, first], best_rate)
            best[better] = np.column_stack([first, np.full(len(first), looks)])[better]
            best_gain = np.where(better, gain[rows, first], best_gain)
            best_s = np.where(better, seconds[rows, first], best_s)
        order = np.argsort(-best_rate, kind="stable")
        return [
            _Option(int(k), int(best[k, 0]), int(best[k, 1]), float(best_gain[k]), float(best_s[k]))
            for k in order[:PLAYED]
            if best_rate[k] > 0
        ]

    def _first_turn_rad(self, yaw: float, looks: int, across: int) -> NDArray[np.float64]:
        """From this heading to the nearer end of each arc."""
        middles = (np.arange(BINS) + across / 2) * BIN_RAD
        half = (looks - 1) * self._pace.step_rad / 2
        ends = np.stack([middles - half, middles + half]) - yaw
        return np.abs((ends + np.pi) % (2 * np.pi) - np.pi).min(axis=0)

    def _gains(self, mass: NDArray[np.float64], doubt: NDArray[np.float64]) -> NDArray[np.float64]:
        """(places, bins): the probability that a look there shows it."""
        old = doubt[self._side]
        shown = mass[self._cell] * np.maximum(0.0, self._chance - old) / np.maximum(1.0 - old, 1e-9)
        size = len(self._places) * BINS
        return np.bincount(self._place * BINS + self._bin, shown, size).astype(float).reshape(-1, BINS)

    def _travel_s(self, at: int) -> NDArray[np.float64]:
        metres = self._metres(at)
        return np.where(metres > 0.0, metres / self._pace.speed_m_s + self._pace.drive_s, 0.0)

    def _metres(self, at: int) -> NDArray[np.float64]:
        if at not in self._walks:
            self._walks[at] = walks_m(self._belief.coarse, self._places, self._places[at : at + 1])[0]
            self._walks[at][at] = 0.0
        return self._walks[at]

    def _expected_s(self, first: _Option, here: float) -> float:
        """Until it is found, over what is believed to be here, if this view is taken first."""
        mass, doubt = self._mass.copy(), self._doubt.copy()
        option, at_s, expected, left = first, 0.0, 0.0, here
        for _ in range(STEPS):
            at_s += option.seconds
            expected += option.gain * at_s
            left -= option.gain
            self._take(option, mass, doubt)
            yaw = (option.first_bin * BIN_RAD + self._arc_rad(option.looks)) % (2 * math.pi)
            later = self._options(option.place, yaw, mass, doubt)
            if not later:
                break
            option = later[0]
        return expected + max(0.0, left) * (at_s + TAIL_S)

    def _take(self, option: _Option, mass: NDArray[np.float64], doubt: NDArray[np.float64]) -> None:
        """As `BeliefMap.look` does, of the arc at once; what is left is not normalised: it stays a share of now."""
        across = min(BINS, int(self._arc_rad(option.looks) / BIN_RAD))
        bins = np.zeros(BINS, dtype=bool)
        bins[(option.first_bin + np.arange(across)) % BINS] = True
        mine = slice(*np.searchsorted(self._place, [option.place, option.place + 1]))
        shown = bins[self._bin[mine]]
        cells, sides, new = self._cell[mine][shown], self._side[mine][shown], self._chance[mine][shown]
        old = doubt[sides]
        mass[cells] *= np.minimum(1.0, (1.0 - new) / np.maximum(1.0 - old, 1e-9))
        doubt[sides] = np.maximum(old, new)

    def _arc_rad(self, looks: int) -> float:
        return self._pace.hfov_rad + (looks - 1) * self._pace.step_rad

    def _view(self, option: _Option) -> NextView:
        x, y = self._here.x, self._here.y
        if option.place != 0:
            x, y = self._belief.point(*map(int, self._places[option.place]))
        across = min(BINS, int(self._arc_rad(option.looks) / BIN_RAD))
        middle = (option.first_bin + across / 2) * BIN_RAD
        half = (option.looks - 1) * self._pace.step_rad / 2
        headings = [wrap(middle - half + k * self._pace.step_rad) for k in range(option.looks)]
        towards = self._here.yaw if option.place == 0 else math.atan2(y - self._here.y, x - self._here.x)
        if abs(wrap(headings[-1] - towards)) < abs(wrap(headings[0] - towards)):
            headings.reverse()
        pose = Pose2D(x=x, y=y, yaw=headings[0])
        return NextView(pose, tuple(headings), option.gain, option.seconds, float(self._metres(0)[option.place]))

    def _sentence(self, view: NextView, here: float) -> str:
        where = "here" if view.metres == 0 else f"{view.metres:.1f} m away"
        looks = f"{len(view.headings)} look{'s' if len(view.headings) > 1 else ''}"
        near = [c for c in self._belief.clues if math.hypot(c.x - view.pose.x, c.y - view.pose.y) <= NEAR_M]
        best = max(near, key=lambda clue: (clue.itself, clue.weight), default=None)
        why = f", {best.why}" if best is not None else ""
        return f"{looks} {where}{why}: {view.gain:.0%} to see it, in {view.seconds:.0f} s; {here:.0%} that it is here"
