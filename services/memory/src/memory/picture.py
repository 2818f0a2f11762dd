"""The map of what is remembered, as SVG (pure): objects by belief and age, views as arrows, where a thing moved."""

import math
from collections.abc import Iterable, Sequence
from xml.sax.saxutils import escape

import numpy as np

from contracts.memory import ObjectState, RememberedObject
from geometry.grids import OccupancyGrid
from memory.ports import StoredView

PX_A_METRE = 60.0
BORDER_M = 0.5
FILL = {
    ObjectState.PRESENT: "#1b7f4d",
    ObjectState.DOUBTFUL: "#b7791f",
    ObjectState.LOST: "#8a8f98",
    ObjectState.MOVED: "#8a8f98",
}
STYLE = (
    "text{font:11px system-ui,sans-serif;fill:#1f2933}.view{stroke:#5a7fb8;stroke-width:1}"
    ".wall{fill:#3d4652}.moved{stroke:#8a8f98;stroke-width:1.5;stroke-dasharray:4 3;fill:none}"
)


def map_svg(
    things: Sequence[RememberedObject], views: Iterable[StoredView], ground: OccupancyGrid | None, now_s: float
) -> str:
    """Metres become 60 px; x to the right, y upwards. An object's opacity is its belief, its caption tells its age."""
    arrows = list(views)
    paper = _Paper.round(
        [(one.position.x, one.position.y) for one in things] + [(one.x, one.y) for one in arrows] + _corners(ground)
    )
    at = {one.id: one for one in things}
    parts = [*_walls(ground, paper), *(_arrow(one, paper) for one in arrows)]
    parts += [_way(at[one.moved_from], one, paper) for one in things if one.moved_from in at]
    parts += [_thing(one, paper, now_s) for one in sorted(things, key=lambda one: one.belief)]
    width, height = paper.size
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" width="{width:.0f}" '
        f'height="{height:.0f}" role="img" aria-label="map of remembered objects"><style>{STYLE}</style>'
        f'<rect width="100%" height="100%" fill="#f7f9fb"/>{"".join(parts)}</svg>'
    )


class _Paper:
    """Where metres of the map are on the picture."""

    def __init__(self, x_min: float, y_min: float, x_max: float, y_max: float) -> None:
        self.x_min, self.y_max = x_min, y_max
        self.scale = min(PX_A_METRE, 4000.0 / max(x_max - x_min, y_max - y_min))
        self.size = ((x_max - x_min) * self.scale, (y_max - y_min) * self.scale)

    @classmethod
    def round(cls, points: Sequence[tuple[float, float]]) -> "_Paper":
        xs, ys = [x for x, _ in points] or [0.0], [y for _, y in points] or [0.0]
        return cls(min(xs) - BORDER_M, min(ys) - BORDER_M, max(xs) + BORDER_M, max(ys) + BORDER_M)

    def at(self, x: float, y: float) -> tuple[float, float]:
        return (x - self.x_min) * self.scale, (self.y_max - y) * self.scale


def _corners(ground: OccupancyGrid | None) -> list[tuple[float, float]]:
    if ground is None:
        return []
    rows, columns = ground.cells.shape
    x, y = ground.points(np.array([0, columns, columns, 0]), np.array([0, 0, rows, rows]))
    return list(zip(x.tolist(), y.tolist(), strict=True))


def _walls(ground: OccupancyGrid | None, paper: _Paper) -> Iterable[str]:
    """One rectangle for each run of occupied cells in a row, in cells of the map, which may be turned."""
    if ground is None:
        return
    side, yaw = ground.resolution_m * paper.scale, ground.origin.yaw
    c, s = side * math.cos(yaw), side * math.sin(yaw)
    x, y = paper.at(ground.origin.x, ground.origin.y)
    yield f'<g transform="matrix({c:.5f} {-s:.5f} {-s:.5f} {-c:.5f} {x:.2f} {y:.2f})">'
    edges = np.diff(np.pad(ground.occupied, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    for (row, start), end in zip(
        np.argwhere(edges == 1).tolist(), np.argwhere(edges == -1)[:, 1].tolist(), strict=True
    ):
        yield f'<rect class="wall" x="{start}" y="{row}" width="{end - start}" height="1"/>'
    yield "</g>"


def _arrow(view: StoredView, paper: _Paper) -> str:
    x, y = paper.at(view.x, view.y)
    dx, dy = 9.0 * math.cos(view.yaw), -9.0 * math.sin(view.yaw)
    return (
        f'<line class="view" x1="{x:.1f}" y1="{y:.1f}" x2="{x + dx:.1f}" y2="{y + dy:.1f}" '
        f'opacity="{0.25 + 0.5 * view.confidence:.2f}"><title>{escape(view.label)} {view.confidence:.2f}</title></line>'
    )


def _way(before: RememberedObject, after: RememberedObject, paper: _Paper) -> str:
    (x1, y1), (x2, y2) = paper.at(before.position.x, before.position.y), paper.at(after.position.x, after.position.y)
    return f'<path class="moved" d="M{x1:.1f} {y1:.1f}L{x2:.1f} {y2:.1f}"/>'


def _thing(one: RememberedObject, paper: _Paper, now_s: float) -> str:
    x, y = paper.at(one.position.x, one.position.y)
    caption = f"{one.description} {one.belief:.0%}, {age(now_s - one.last_seen_s)}"
    return (
        f'<g id="object-{one.id}" data-state="{one.state.value}"><circle cx="{x:.1f}" cy="{y:.1f}" r="6" '
        f'fill="{FILL[one.state]}" opacity="{0.25 + 0.75 * one.belief:.2f}"/>'
        f'<text x="{x + 9.0:.1f}" y="{y + 4.0:.1f}">{escape(caption)}</text></g>'
    )


def age(seconds: float) -> str:
    """In the largest unit that fits: '5 min', '3 h', '12 d'."""
    for unit, length_s in (("d", 86_400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= length_s:
            return f"{seconds / length_s:.0f} {unit}"
    return "now"
