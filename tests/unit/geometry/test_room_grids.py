"""Where rooms lie, one byte a cell: what comes back, and what is refused."""

import base64
import zlib

import numpy as np
import pytest
from pydantic import ValidationError

from bench.map_likeness import home_grid
from contracts.geometry import Pose2D
from contracts.rooms import ROOM_CELLS_MAX, RoomGrid
from geometry.room_grids import RoomGridError, decode, encode
from geometry.rooms import rooms_of

ORIGIN = Pose2D(x=0.0, y=0.0, yaw=0.0)


def grid(raw: bytes, ids: tuple[int, ...] = (7, 9)) -> RoomGrid:
    packed = base64.b64encode(zlib.compress(raw)).decode()
    return RoomGrid(width=3, height=2, resolution_m=0.05, origin=ORIGIN, ids=ids, cells_base64=packed)


def test_each_cell_comes_back_as_the_id_of_its_room() -> None:
    found = rooms_of(home_grid(7021))
    ids = {room.number: 100 + room.number for room in found.rooms}
    back = decode(encode(found, ids, map_id="home"))
    assert len(found.rooms) > 2
    assert (back.ids[found.labels > 0] == found.labels[found.labels > 0] + 100).all()
    assert not back.ids[found.labels == 0].any()
    assert (back.resolution_m, back.origin) == (found.grid.resolution_m, found.grid.origin)


def test_a_room_without_an_id_is_no_room_and_what_is_no_room_is_of_none() -> None:
    found = rooms_of(home_grid(7021))
    back = decode(encode(found, {2: 41}, map_id=""))
    assert (back.of([41]) == found.mask(2)).all()
    assert not back.of([0]).any()
    assert not back.of([]).any()


@pytest.mark.parametrize(
    ("raw", "what"),
    [
        (bytes(5), "5 cells"),
        (bytes(7), "7 cells"),
        (bytes((0, 1, 2, 3, 0, 0)), "room 3"),
    ],
)
def test_cells_that_are_not_what_the_fields_say_are_refused(raw: bytes, what: str) -> None:
    with pytest.raises(RoomGridError, match=what):
        decode(grid(raw))


def test_what_is_not_packed_is_refused() -> None:
    with pytest.raises(RoomGridError, match="cannot be unpacked"):
        decode(grid(bytes(6)).model_copy(update={"cells_base64": "AAAA"}))


def test_no_message_is_larger_than_a_map_that_is_cut() -> None:
    with pytest.raises(ValidationError, match="no more than"):
        RoomGrid(width=ROOM_CELLS_MAX, height=2, resolution_m=0.05, origin=ORIGIN, ids=(), cells_base64="")


def test_numbers_come_back_as_they_were_told() -> None:
    assert np.array_equal(decode(grid(bytes((0, 1, 2, 2, 1, 0)))).ids, [[0, 7, 9], [9, 7, 0]])
