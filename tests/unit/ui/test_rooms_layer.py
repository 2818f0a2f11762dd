"""The map's layer of rooms."""

import base64
import io
from typing import Any

import numpy as np
import pytest
from PIL import Image

from contracts.geometry import Pose2D
from contracts.rooms import NamedBy, NamedRoom
from geometry import room_grids
from geometry.grids import decode
from geometry.rooms import Rooms, rooms_of
from support.ui_world import home_map
from ui import map_view, rooms_layer
from ui.latest_facts import ShownRooms
from ui.rooms_layer import DOORWAY_ALPHA, TINT_ALPHA

FRAME = map_view.picture(home_map()).frame
CUT = rooms_of(decode(home_map()))


def known(cut: Rooms = CUT, by: NamedBy = NamedBy.CONTENTS) -> ShownRooms:
    ids = {one.number: 10 * one.number for one in cut.rooms}
    named = tuple(
        NamedRoom(id=10 * r.number, name=f"room {r.number}", named_by=by, x=r.x_m, y=r.y_m, area_m2=r.area_m2)
        for r in cut.rooms
    )
    grid = room_grids.encode(cut, ids, map_id="home")
    return ShownRooms("home", named, grid, rooms_layer.picture(grid))


def pixels(layer: Any) -> np.ndarray:
    png = base64.b64decode(layer["png"].removeprefix("data:image/png;base64,"), validate=True)
    return np.asarray(Image.open(io.BytesIO(png)))


def test_each_room_has_a_light_tint_of_its_own_and_walls_and_furniture_have_none() -> None:
    tinted = pixels(rooms_layer.rooms(FRAME, known(), map_id="home"))
    assert len(CUT.rooms) == 4
    inside = {tuple(tinted[CUT.mask(room.number) & (tinted[..., 3] == TINT_ALPHA)][0].tolist()) for room in CUT.rooms}
    assert len(inside) == 4
    assert not tinted[CUT.labels == 0].any()


def test_the_doorways_between_rooms_are_drawn_stronger() -> None:
    strong = pixels(rooms_layer.rooms(FRAME, known(), map_id="home"))[..., 3] == DOORWAY_ALPHA
    assert 40 <= strong.sum() <= 120  # four doors of 18 cells


def test_a_name_stands_at_the_roomiest_place_and_says_who_gave_it() -> None:
    first = CUT.rooms[0]
    layer = rooms_layer.rooms(FRAME, known(), map_id="home")
    assert layer["names"][0] == {
        "id": 10,
        "at": pytest.approx(FRAME.to_px(first.x_m, first.y_m), abs=0.1),
        "name": "room 1",
        "by": "contents",
        "why": "guessed from what stands there",
    }


def test_a_cell_of_the_picture_lies_where_it_lies_in_the_map() -> None:
    a, b, c, d, e, f = rooms_layer.rooms(FRAME, known(), map_id=None)["fit"]
    x, y = CUT.grid.points(12.0, 7.0)
    assert (a * 12 + c * 7 + e, b * 12 + d * 7 + f) == pytest.approx(FRAME.to_px(float(x), float(y)), abs=0.01)


@pytest.mark.parametrize(
    ("told", "map_id"),
    [(ShownRooms(), "home"), (known(), "another"), (ShownRooms("home", known().rooms, None), "home")],
)
def test_rooms_of_another_home_or_of_none_are_not_drawn(told: ShownRooms, map_id: str) -> None:
    assert rooms_layer.rooms(FRAME, told, map_id=map_id) == {"png": "", "fit": [], "names": []}


def test_cells_that_make_no_sense_are_not_drawn() -> None:
    grid = known().grid
    assert grid is not None
    broken_grid = grid.model_copy(update={"cells_base64": "AAAA"})
    broken = ShownRooms("home", known().rooms, broken_grid, rooms_layer.picture(broken_grid))
    assert rooms_layer.rooms(FRAME, broken, map_id="home")["names"] == []


def test_the_frame_is_the_maps_own() -> None:
    assert FRAME.grid.origin == Pose2D(x=-4.5, y=-3.75, yaw=0.0)
