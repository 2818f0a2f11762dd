"""The map's layer of what a search holds probable."""

import base64
import io
from typing import Any

import numpy as np
import pytest
from PIL import Image

from contracts.belief import NoBelief, SearchBelief
from contracts.geometry import Pose2D
from geometry import probability_grids
from support.ui_world import home_map, search_belief
from ui import belief_layer, map_view

FRAME = map_view.picture(home_map()).frame
TURNED = Pose2D(x=1.0, y=-2.0, yaw=0.7)


def drawn(told: SearchBelief | NoBelief | None, *, mission_id: str = "m-1", map_id: str | None = None) -> Any:
    return belief_layer.belief(FRAME, told, mission_id=mission_id, map_id=map_id)


def strengths(layer: Any) -> np.ndarray:
    """(height, width) 0 to 255 of the layer's picture."""
    png = base64.b64decode(layer["png"].removeprefix("data:image/png;base64,"), validate=True)
    return np.asarray(Image.open(io.BytesIO(png)))[:, :, 1]


def test_the_most_probable_cell_is_the_strongest_and_where_nothing_can_be_nothing_is_drawn() -> None:
    alpha = strengths(drawn(search_belief()))
    assert alpha.shape == (50, 60)
    assert alpha[10, 42] == 255
    assert alpha[30, 20] == pytest.approx(46, abs=2)  # 168 times less probable
    assert alpha[0, 0] == 0


@pytest.mark.parametrize("origin", [Pose2D(x=-4.5, y=-3.75, yaw=0.0), TURNED])
def test_a_cell_of_the_picture_lies_where_it_lies_in_the_map(origin: Pose2D) -> None:
    cells = np.full((20, 30), 0.001)
    grid = probability_grids.encode(cells, resolution_m=0.15, origin=origin)
    a, b, c, d, e, f = drawn(search_belief(grid=grid))["fit"]
    cos, sin = np.cos(origin.yaw), np.sin(origin.yaw)
    x, y = 0.15 * 12, 0.15 * 7  # along the grid's own axes
    expected = FRAME.to_px(origin.x + cos * x - sin * y, origin.y + sin * x + cos * y)
    assert (a * 12 + c * 7 + e, b * 12 + d * 7 + f) == pytest.approx(expected, abs=0.01)


def test_the_words_say_how_surely_it_is_not_here_and_why_the_robot_looks_there_next() -> None:
    layer = drawn(search_belief())
    assert (layer["absent"], layer["peak"]) == ("Not here: 20 %", "2.5 % in 15 cm")
    assert layer["why"].startswith("2 looks 3.1 m away, near the sink")
    assert layer["view"]["at"] == pytest.approx(FRAME.to_px(1.0, -1.0), abs=0.1)
    assert layer["view"]["turns"] == pytest.approx([0.6, -0.1], abs=0.01)  # clockwise on a screen


def test_where_nothing_is_worth_a_look_there_is_no_next_place() -> None:
    assert drawn(search_belief(view=None, why="what is left is not worth a look"))["view"] is None


@pytest.mark.parametrize("why", NoBelief)
def test_a_mission_without_a_belief_says_why(why: NoBelief) -> None:
    layer = drawn(why)
    assert (layer["png"], layer["absent"]) == ("", "")
    assert layer["why"] == belief_layer.MISSING[why]


def test_no_belief_is_drawn_of_another_mission_another_home_or_of_broken_levels() -> None:
    broken = search_belief().grid.model_copy(update={"levels_base64": "AAAA"})
    not_ours = [
        drawn(None),
        drawn(search_belief(), mission_id="m-2"),
        drawn(search_belief(map_id="home-1"), map_id="home-2"),
        drawn(search_belief(grid=broken)),
    ]
    assert [(one["png"], one["why"]) for one in not_ours] == [("", belief_layer.UNKNOWN)] * 4
    assert drawn(search_belief(map_id="home-1"), map_id="home-1")["png"] != ""


def test_a_belief_in_nothing_on_this_map_is_an_empty_picture() -> None:
    grid = probability_grids.encode(np.zeros((5, 4)), resolution_m=0.15, origin=TURNED)
    assert not strengths(drawn(search_belief(grid=grid, absent=1.0))).any()


@pytest.mark.parametrize(
    ("share", "text"),
    [(0.0, "0 %"), (1.0, "100 %"), (0.2, "20 %"), (0.034, "3.4 %"), (0.0042, "0.42 %"), (1e-9, "< 0.01 %")],
)
def test_a_share_is_told_in_two_digits(share: float, text: str) -> None:
    assert belief_layer.percent(share) == text
