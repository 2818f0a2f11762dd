"""The map's picture and the marks above it."""

import io
import math

import numpy as np
import pytest
from PIL import Image

from contracts.geometry import Pose2D
from geometry.grids import MapError
from support.ui_world import home_map, packed
from ui import map_view

ORIGIN = Pose2D(x=-1.0, y=-2.0, yaw=0.0)


def room() -> np.ndarray:
    """20 x 30 cells, known from (5, 5) on: free, but for a wall along its lowest row."""
    cells = np.full((20, 30), -1, np.int8)
    cells[5:15, 5:25] = 0
    cells[5, 5:25] = 100
    return cells


def test_the_picture_holds_what_is_known_with_a_margin_and_y_up() -> None:
    picture = map_view.picture(packed(room(), ORIGIN))
    image = np.array(Image.open(io.BytesIO(picture.png)))
    assert image.shape == (picture.frame.height_px, picture.frame.width_px) == (18, 28)
    assert (image[-1 - map_view.MARGIN_CELLS, 4:-4] == map_view.OCCUPIED).all()
    assert (image[4:-5, 4:-4] == map_view.FREE).all()
    assert (image[:4] == map_view.UNKNOWN).all()


def test_a_cell_that_is_neither_free_nor_occupied_is_not_drawn_as_free() -> None:
    cells = np.zeros((3, 5), np.int8)
    cells[1] = (0, 50, 100, 127, -1)
    image = np.array(Image.open(io.BytesIO(map_view.picture(packed(cells, ORIGIN)).png)))
    kinds = (map_view.FREE, map_view.UNKNOWN, map_view.OCCUPIED, map_view.UNKNOWN, map_view.UNKNOWN)
    assert image[1].tolist() == list(kinds)


def test_unknown_is_transparent_so_that_one_picture_suits_light_and_dark() -> None:
    picture = map_view.picture(home_map())
    alpha = np.array(Image.open(io.BytesIO(picture.png)).convert("RGBA"))[..., 3]
    assert alpha[0, 0] == 0
    assert alpha.max() == 255


def test_a_map_without_anything_known_is_shown_whole() -> None:
    picture = map_view.picture(packed(np.full((8, 9), -1, np.int8), ORIGIN))
    assert (picture.frame.width_px, picture.frame.height_px) == (9, 8)


def test_a_point_of_the_map_lands_on_its_cell() -> None:
    frame = map_view.picture(packed(room(), ORIGIN)).frame
    x, y = frame.to_px(-1.0 + 0.05 * 5.5, -2.0 + 0.05 * 5.5)
    assert x == pytest.approx(4.5)
    assert y == pytest.approx(18 - 4.5)


def test_a_turned_origin_turns_points_and_headings_with_it() -> None:
    turned = Pose2D(x=0.0, y=0.0, yaw=math.pi / 2)
    frame = map_view.picture(packed(np.zeros((10, 10), np.int8), turned)).frame
    assert frame.to_px(0.0, 0.25) == pytest.approx((5.0, 10.0))
    assert frame.heading_deg(math.pi / 2) == pytest.approx(0.0)


def test_a_point_of_the_picture_leads_back_to_the_map() -> None:
    turned = Pose2D(x=0.4, y=-1.0, yaw=0.7)
    frame = map_view.picture(packed(np.zeros((30, 40), np.int8), turned)).frame
    assert frame.to_map(*frame.to_px(1.1, -0.3)) == pytest.approx((1.1, -0.3))


def test_a_map_whose_cells_are_too_few_is_refused() -> None:
    grid = home_map()
    with pytest.raises(MapError, match="cells"):
        map_view.picture(grid.model_copy(update={"height": grid.height + 1}))


def test_a_map_that_is_no_zlib_is_refused() -> None:
    with pytest.raises(MapError, match="unpacked"):
        map_view.picture(home_map().model_copy(update={"data_base64": "bm90IHpsaWI="}))


def test_another_map_has_another_version() -> None:
    assert map_view.version(home_map()) == map_view.version(home_map())
    assert map_view.version(home_map()) != map_view.version(home_map(width=190))
