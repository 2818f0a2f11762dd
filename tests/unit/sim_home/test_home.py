"""Homes are the same for a seed, hold what was asked for, can be driven through, and survive a file."""

import json
import math
from pathlib import Path

import mujoco
import numpy as np
import pytest

from sim.home import Home, HomeFileError, Thing, Wanted, home_mjcf
from sim.home.catalog import ALL_COLOURS, COLOURS, FURNITURE, KINDS, THINGS
from sim.home.floor import APPROACH_M, STANDING_RADIUS_M, Floor
from sim.home.layout import Layout, door_zone
from sim.world.robot import CAMERA_Z_M

SEEDS = range(20)
HALF_VIEW_RAD = math.radians(27)


@pytest.fixture(scope="module")
def homes() -> list[Home]:
    return [Home.generate(seed) for seed in SEEDS]


@pytest.fixture(scope="module")
def floors(homes: list[Home]) -> list[Floor]:
    return [furnished_floor(home) for home in homes]


def furnished_floor(home: Home) -> Floor:
    """The floor as the finished home covers it, drawn from its data alone."""
    floor = Floor(Layout(home.width_m, home.depth_m, home.rooms, home.walls, home.doors, home.dock))
    for piece in home.furniture:
        floor.occupied |= floor.footprint(piece.x_m, piece.y_m, piece.yaw, piece.size_m[0], piece.size_m[1])
    for thing in on_the_floor(home):
        side = max(thing.size_m[:2])
        floor.occupied |= floor.footprint(thing.x_m, thing.y_m, 0.0, side, side)
    return floor


def on_the_floor(home: Home) -> list[Thing]:
    return [thing for thing in home.things if thing.support == "floor"]


def findable(home: Home) -> list[Thing]:
    return [thing for thing in home.things if THINGS[thing.kind].findable]


def test_a_seed_always_gives_the_same_home_and_another_seed_another(homes: list[Home]) -> None:
    assert Home.generate(3) == homes[3]
    assert homes[3] != homes[4]
    assert home_mjcf(homes[3]) == home_mjcf(homes[3])


def test_a_home_has_four_to_six_rooms_in_the_agreed_size_and_is_well_furnished(homes: list[Home]) -> None:
    assert {len(home.rooms) for home in homes} == {4, 5, 6}
    assert all(8.9 < home.width_m < 11 and 7 < home.depth_m < 9 for home in homes)
    assert all(32 <= len(home.things) + len(home.furniture) <= 64 for home in homes)


def test_doorways_are_wide_enough_and_every_room_has_one(homes: list[Home]) -> None:
    for home in homes:
        assert all(door.width_m >= 0.9 for door in home.doors)
        for room in home.rooms:
            zones = [door_zone(door) for door in home.doors]
            assert any(
                z.x_min_m < room.x_max_m
                and z.x_max_m > room.x_min_m
                and z.y_min_m < room.y_max_m
                and z.y_max_m > room.y_min_m
                for z in zones
            )


def test_every_room_can_be_reached_from_the_dock_with_passages_of_70_cm(homes: list[Home], floors: list[Floor]) -> None:
    assert 2 * STANDING_RADIUS_M >= 0.7
    for home, floor in zip(homes, floors, strict=True):
        standing = floor.standing()
        assert standing is not None
        for room in home.rooms:
            inside = (floor.x_m > room.x_min_m) & (floor.x_m < room.x_max_m)
            inside = inside & (floor.y_m > room.y_min_m) & (floor.y_m < room.y_max_m)
            assert (standing & inside).sum() * 0.0025 > 0.3, room.name


def test_every_findable_thing_is_seen_by_the_low_camera_from_a_free_place_near_it(
    homes: list[Home], floors: list[Floor]
) -> None:
    seen = total = 0
    for home, floor in zip(homes[:8], floors[:8], strict=True):
        text, assets = home_mjcf(home)
        model = mujoco.MjModel.from_xml_string(text, assets)
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        standing = floor.standing()
        assert standing is not None
        for thing in findable(home):
            total += 1
            seen += sees_from_near(model, data, floor, standing, thing)
    assert seen == total


def sees_from_near(
    model: mujoco.MjModel, data: mujoco.MjData, floor: Floor, standing: np.ndarray, thing: Thing
) -> bool:
    """Whether a ray from some standing place within reach, inside the camera's view, hits the thing first."""
    rows, columns = np.nonzero(standing & (np.hypot(floor.x_m - thing.x_m, floor.y_m - thing.y_m) <= APPROACH_M))
    hit = np.zeros(1, np.int32)
    for row, column in list(zip(rows, columns, strict=True))[::2]:
        eye = np.array([floor.x_m[0, column], floor.y_m[row, 0], CAMERA_Z_M])
        for part in (0.5, 0.75, 0.25):
            ray = np.array([thing.x_m, thing.y_m, thing.z_m + part * thing.size_m[2]]) - eye
            if abs(math.atan2(ray[2], math.hypot(ray[0], ray[1]))) > HALF_VIEW_RAD:
                continue
            mujoco.mj_ray(model, data, eye, ray, None, 1, -1, hit)
            if hit[0] >= 0 and model.body(model.geom_bodyid[hit[0]]).name == thing.id:
                return True
    return False


def test_things_on_the_floor_stand_beside_something_and_never_in_a_doorway_or_before_the_dock(
    homes: list[Home],
) -> None:
    for home in homes:
        layout = Layout(home.width_m, home.depth_m, home.rooms, home.walls, home.doors, home.dock)
        bare = Floor(layout)
        for piece in home.furniture:
            bare.occupied |= bare.footprint(piece.x_m, piece.y_m, piece.yaw, piece.size_m[0], piece.size_m[1])
        clearance = bare.clearance_m()
        for thing in on_the_floor(home):
            assert clearance[bare.cell(thing.x_m, thing.y_m)] <= max(thing.size_m[:2]) / 2 + 0.2
            for zone in layout.keep_free:
                assert not (zone.x_min_m < thing.x_m < zone.x_max_m and zone.y_min_m < thing.y_m < zone.y_max_m), thing


def test_furniture_stands_inside_its_home_and_pieces_do_not_run_into_each_other(homes: list[Home]) -> None:
    for home in homes:
        inside = [any(room.contains(piece.x_m, piece.y_m) for room in home.rooms) for piece in home.furniture]
        assert all(inside)
        solid = [p for p in home.furniture if p.kind not in ("chair", "dining table")]
        for k, first in enumerate(solid):
            for second in solid[:k]:
                apart = math.hypot(first.x_m - second.x_m, first.y_m - second.y_m)
                assert apart > (min(first.size_m[:2]) + min(second.size_m[:2])) / 2 - 0.01, (first.id, second.id)


def test_things_stand_on_the_furniture_they_name(homes: list[Home]) -> None:
    for home in homes:
        pieces = {piece.id: piece for piece in home.furniture}
        for thing in (t for t in home.things if t.support not in ("floor", "wall")):
            piece = pieces[thing.support]
            assert math.hypot(thing.x_m - piece.x_m, thing.y_m - piece.y_m) < math.hypot(*piece.size_m[:2]) / 2
            assert 0 < thing.z_m <= piece.size_m[2] + 0.01


def test_no_two_things_share_kind_and_colour_where_the_kind_has_colours(homes: list[Home]) -> None:
    for home in homes:
        named = [(thing.kind, thing.colour) for thing in home.things if thing.colour is not None]
        assert len(named) == len(set(named))


def test_ids_are_unique_across_things_and_furniture(homes: list[Home]) -> None:
    for home in homes:
        ids = [item.id for item in (*home.things, *home.furniture)]
        assert len(ids) == len(set(ids))


def test_more_than_25_coco_kinds_and_all_eight_colours_appear(homes: list[Home]) -> None:
    items = [item for home in homes for item in (*home.things, *home.furniture)]
    assert len({item.kind for item in items if KINDS[item.kind].coco_id is not None}) >= 30
    assert set(COLOURS) <= {item.colour for item in items} <= {*ALL_COLOURS, None}


@pytest.mark.parametrize(
    ("kind", "colour"),
    [
        ("bottle", "red"),
        ("teddy bear", "brown"),
        ("umbrella", "yellow"),
        ("suitcase", "orange"),
        ("couch", "blue"),
        ("chair", "red"),
    ],
)
def test_the_wanted_thing_is_there_once_with_another_colour_of_its_kind(kind: str, colour: str) -> None:
    home = Home.generate(11, wanted=Wanted(kind, colour))
    colours = [item.colour for item in (*home.things, *home.furniture) if item.kind == kind]
    assert colours.count(colour) == 1
    assert len(set(colours)) >= 2


@pytest.mark.parametrize("kind", ["clock", "potted plant", "toilet", "laptop", "wine glass"])
def test_a_wanted_kind_without_colours_is_there_once(kind: str) -> None:
    home = Home.generate(12, wanted=Wanted(kind))
    assert [item.kind for item in (*home.things, *home.furniture)].count(kind) == 1


def test_a_wanted_kind_without_a_named_colour_comes_in_two_colours() -> None:
    home = Home.generate(13, wanted=Wanted("vase"))
    assert len({thing.colour for thing in home.things if thing.kind == "vase"}) >= 2


def test_every_kind_can_be_wanted() -> None:
    assert set(KINDS) == set(THINGS) | set(FURNITURE)
    for seed, kind in enumerate(("sink", "microwave", "tv", "bench", "dining table", "banana")):
        home = Home.generate(seed, wanted=Wanted(kind))
        assert kind in {item.kind for item in (*home.things, *home.furniture)}


@pytest.mark.parametrize(
    ("wanted", "sentence"),
    [(Wanted("unicorn"), "unicorn"), (Wanted("cup", "brown"), "brown"), (Wanted("clock", "red"), "natural colour")],
)
def test_what_no_home_can_hold_is_refused_with_a_reason(wanted: Wanted, sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        Home.generate(1, wanted=wanted)


def test_a_home_survives_saving_and_loading(homes: list[Home], tmp_path: Path) -> None:
    homes[5].save(tmp_path / "home.json")
    assert Home.load(tmp_path / "home.json") == homes[5]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("{", "not JSON"),
        ("[]", "version 1"),
        ('{"version": 2, "home": {}}', "version 1"),
        ('{"version": 1, "home": {"seed": 1}}', "rooms"),
    ],
)
def test_a_malformed_file_is_refused_with_a_reason(tmp_path: Path, text: str, sentence: str) -> None:
    (tmp_path / "home.json").write_text(text)
    with pytest.raises(HomeFileError, match=sentence):
        Home.load(tmp_path / "home.json")


def test_a_file_with_an_unknown_field_is_refused(homes: list[Home], tmp_path: Path) -> None:
    path = tmp_path / "home.json"
    homes[0].save(path)
    body = json.loads(path.read_text())
    body["home"]["things"][0]["weight_kg"] = 3
    path.write_text(json.dumps(body))
    with pytest.raises(HomeFileError, match="weight_kg"):
        Home.load(path)
