"""Which home a map is of, over restarts; and the dock, which belongs to one."""

import asyncio
from pathlib import Path

import pytest

from bench.map_likeness import changed
from contracts.geometry import Pose2D
from contracts.robot import KnownMap
from mesh.errors import ConflictError, NotFoundError
from mesh.latest_value import LatestValue
from robot_bridge.navigation.dock_pose import DockPose
from robot_bridge.navigation.map_book import MapBook
from robot_bridge.sensing.sensor_readings import DockView, Grid
from robot_bridge.sensing.snapshot import Snapshot
from support.fake_clock import FakeClock
from support.homes import home
from support.waiting import until

DOCK = Pose2D(x=1.0, y=2.0, yaw=0.5)
CHANGED = {name: Grid(grid.cells, grid.resolution_m, grid.origin) for name, grid in changed(home(0))}


def grid_of(seed: int) -> Grid:
    grid = home(seed)
    return Grid(grid.cells, grid.resolution_m, grid.origin)


def book_in(folder: Path) -> MapBook:
    return MapBook(folder, LatestValue(), FakeClock())


async def named(book: MapBook, *grids: Grid) -> list[str]:
    return [(await book.name(grid)).id for grid in grids]


async def test_a_home_keeps_its_name_however_its_map_comes_and_over_restarts(tmp_path: Path) -> None:
    book = book_in(tmp_path)
    assert book.current is None
    first = (await named(book, grid_of(0)))[0]
    assert set(await named(book, *CHANGED.values())) == {first}
    assert set(await named(book_in(tmp_path), *CHANGED.values())) == {first}


async def test_a_map_that_grows_from_a_corner_keeps_its_name(tmp_path: Path) -> None:
    book, whole = book_in(tmp_path), grid_of(0)
    grown: list[Grid] = []
    for columns in range(60, whole.cells.shape[1], 20):
        cells = whole.cells.copy()
        cells[:, columns:] = -1
        grown.append(Grid(cells, whole.resolution_m, whole.origin))
    assert len(set(await named(book, *grown, whole))) == 1
    assert (await named(book_in(tmp_path), whole))[0] == book.known()[0].id


async def test_another_home_has_another_name_and_the_first_one_is_known_again(tmp_path: Path) -> None:
    book = book_in(tmp_path)
    names = await named(book, grid_of(0), grid_of(1), grid_of(2), grid_of(0))
    assert names[0] == names[3]
    assert len(set(names)) == 3
    assert [one.id for one in book.known()] == [names[0], names[2], names[1]]


async def test_a_saved_map_has_its_name_by_its_content_where_the_book_was_lost(tmp_path: Path) -> None:
    (tmp_path / "torn").mkdir()
    (tmp_path / "torn" / "maps.json").write_text('{"maps": [')
    names = [(await named(book_in(tmp_path / folder), grid_of(0)))[0] for folder in ("a", "b", "torn")]
    assert len(set(names)) == 1


async def test_a_person_says_that_a_home_changed_much_is_the_same(tmp_path: Path) -> None:
    book, before = book_in(tmp_path), grid_of(0)
    cells = before.cells.copy()
    cells[3:-3, 30:190] = 0  # all walls within, and what stood there
    first, second = await named(book, before, Grid(cells, before.resolution_m, before.origin))
    assert first != second
    said = await book.same_home(first)
    assert (said.id, said.was) == (first, (second,))
    assert book.current == said
    assert [one.id for one in book_in(tmp_path).known()] == [first]


async def test_what_a_person_says_of_two_homes_is_refused_where_their_walls_do_not_fit(tmp_path: Path) -> None:
    book = book_in(tmp_path)
    with pytest.raises(ConflictError, match="no map has been received"):
        await book.same_home("x")
    first, _ = await named(book, grid_of(0), grid_of(1))
    with pytest.raises(ConflictError, match="do not lie on one another"):
        await book.same_home(first)
    with pytest.raises(NotFoundError):
        await book.same_home("never heard of")
    assert len(book.known()) == 2


async def test_each_map_that_comes_is_named_without_being_asked(tmp_path: Path) -> None:
    mailbox: LatestValue[Grid] = LatestValue()
    book = MapBook(tmp_path, mailbox, FakeClock())
    mailbox.put(grid_of(1), 0.0)
    watching = asyncio.create_task(book.watch())
    await until(lambda: book.current is not None)
    watching.cancel()


def docked(at: Pose2D | None) -> Snapshot:
    return Snapshot(0.0, {}, None, None, at, None, None, DockView(is_docked=True), frozenset())


def known(name: str, *was: str) -> KnownMap:
    return KnownMap(id=name, was=was, first_seen_s=0.0, last_seen_s=0.0)


def test_a_dock_belongs_to_the_map_it_was_learned_in(tmp_path: Path) -> None:
    place = DockPose(tmp_path, None)
    place.learn(docked(DOCK), known("home"))
    for again in (place, DockPose(tmp_path, None)):
        assert again.in_map(known("home")) == DOCK
        assert again.in_map(known("renamed", "home")) == DOCK
        assert again.in_map(known("office")) is None
        assert again.in_map(None) is None
        assert again.is_known_elsewhere(known("office"))
        assert not again.is_known_elsewhere(known("home"))


def test_each_map_has_its_own_dock(tmp_path: Path) -> None:
    place, other = DockPose(tmp_path, None), Pose2D(x=-3.0, y=0.0, yaw=0.0)
    place.learn(docked(DOCK), known("home"))
    place.learn(docked(other), known("office"))
    place.learn(docked(None), known("office"))
    assert [place.in_map(known(name)) for name in ("home", "office")] == [DOCK, other]


def test_a_dock_learned_before_maps_had_names_is_of_the_first_map_that_comes(tmp_path: Path) -> None:
    (tmp_path / "dock.json").write_text(DOCK.model_dump_json())
    place = DockPose(tmp_path, None)
    place.learn(docked(None), known("home"))
    again = DockPose(tmp_path, None)
    assert again.in_map(known("home")) == DOCK
    assert again.in_map(known("office")) is None


def test_a_dock_that_is_set_is_believed_in_every_map(tmp_path: Path) -> None:
    place = DockPose(tmp_path, DOCK)
    assert [place.in_map(known("home")), place.in_map(None)] == [DOCK, DOCK]


@pytest.mark.parametrize("left", ["", "[]", '{"x": 1}', '{"docks": 3}', "no json"])
def test_a_dock_file_that_makes_no_sense_is_no_dock(tmp_path: Path, left: str) -> None:
    (tmp_path / "dock.json").write_text(left)
    assert DockPose(tmp_path, None).in_map(known("home")) is None
