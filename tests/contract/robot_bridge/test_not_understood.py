"""What is received and not understood says so, with its reason, wherever a user looks."""

from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import pytest

from contracts.robot import SensorState
from robot_bridge.sensing.sensor_readings import Intrinsics
from support.bridge_behaviour import Rig, running
from support.fake_robot import FakeRobot
from support.toy_robot import ToyRobot

BOX = {"bbox_xyxy": [100, 100, 150, 150], "image_width_px": 250, "image_height_px": 250}
BOXES = {"boxes_xyxy": [[100, 100, 150, 150]], "image_width_px": 250, "image_height_px": 250}
BODIES = {"/depth": BOX, "/localize": BOXES}


class Deaf(FakeRobot):
    """A robot whose sensors send what nobody understands."""

    def never(self, *sensors: str) -> None:
        """As if these had never been understood."""
        boxes = {"rgb_info": "rgb_intrinsics", "depth_info": "depth_intrinsics"}
        for sensor in sensors:
            getattr(self.senses, boxes.get(sensor, sensor))._newest = None
            self.senses.reception.refuse(sensor, "its K has no focal length", 1.0)


@pytest.fixture
async def deaf(tmp_path: Path) -> AsyncIterator[tuple[Rig, Deaf]]:
    toy = ToyRobot()
    robot = Deaf(toy)
    async with running(tmp_path, toy, robot) as rig:
        toy.silent |= {"scan", "rgb", "depth", "map"}
        yield rig, robot


async def ready(rig: Rig) -> dict[str, dict[str, Any]]:
    answer = await rig.client.get("/ready")
    return {one["name"]: one for one in answer.json()["dependencies"]}


@pytest.mark.parametrize("sensor", ["scan", "rgb", "depth", "map", "rgb_info", "depth_info"])
async def test_ready_and_state_tell_the_reason_and_never_that_nothing_came(deaf: tuple[Rig, Deaf], sensor: str) -> None:
    rig, robot = deaf
    robot.never(sensor)
    found = (await ready(rig))[sensor]
    assert found["state"] == "not_ready"
    assert found["detail"] == "received, not understood: its K has no focal length"
    status = (await rig.state()).sensors[sensor]
    assert (status.state, status.detail) == (SensorState.NOT_UNDERSTOOD, "its K has no focal length")


@pytest.mark.parametrize(
    ("sensor", "method", "path"),
    [
        ("map", "GET", "/map"),
        ("map", "GET", "/map.png"),
        ("scan", "GET", "/scan"),
        ("rgb", "GET", "/camera/frame"),
        ("rgb", "GET", "/camera/stream"),
        ("rgb_info", "POST", "/localize"),
        ("rgb_info", "POST", "/depth"),
        ("depth_info", "POST", "/depth"),
        ("depth", "POST", "/depth"),
    ],
)
async def test_what_needs_it_is_refused_with_the_reason(
    deaf: tuple[Rig, Deaf], sensor: str, method: str, path: str
) -> None:
    rig, robot = deaf
    robot.never(sensor)
    robot.senses.depth_history._images = robot.senses.depth_history._images[:0] if sensor == "depth" else ()
    answer = await rig.client.request(method, path, json=BODIES.get(path))
    assert answer.status_code == 503
    assert answer.json()["detail"].endswith(f"{sensor} is received and not understood: its K has no focal length")


async def test_a_camera_info_of_another_cut_than_the_picture_is_named_and_nothing_is_measured_with_it(
    deaf: tuple[Rig, Deaf],
) -> None:
    """The field report's: the middle square of what camera_info describes."""
    rig, robot = deaf
    robot.senses.rgb_intrinsics.put(Intrinsics("optical", 1280, 720, 1000.0, 1000.0, 640.0, 360.0), 1.0)
    why = "camera_info describes 1280 x 720 pixels, the picture has 250 x 250: that is another cut, not another size"
    assert (await ready(rig))["rgb_info"]["detail"] == f"received, not understood: {why}"
    for path, body in (("/localize", BOXES), ("/depth", BOX)):
        answer = await rig.post(path, body)
        assert (answer.status_code, answer.json()["detail"]) == (503, f"rgb_info: {why}")


async def test_a_box_in_a_picture_of_another_shape_than_the_cameras_is_refused(deaf: tuple[Rig, Deaf]) -> None:
    rig, _ = deaf
    answer = await rig.post("/localize", BOXES | {"image_width_px": 320, "image_height_px": 240})
    assert answer.status_code == 422
    assert "camera_info describes 250 x 250 pixels, the picture has 320 x 240" in answer.json()["detail"]
    halved = {"boxes_xyxy": [[50, 50, 75, 75]], "image_width_px": 125, "image_height_px": 125}
    assert (await rig.post("/localize", halved)).status_code == 200


async def test_what_a_person_should_know_of_a_sensor_that_works_is_a_warning(deaf: tuple[Rig, Deaf]) -> None:
    rig, robot = deaf
    robot.senses.reception.take("battery", "its charge is not known: it says nan, not 0 to 1")
    robot.senses.reception.take("map", "many cells")
    found = await ready(rig)
    assert found["battery"]["state"] == found["map"]["state"] == "warning"
    assert found["battery"]["detail"].endswith("its charge is not known: it says nan, not 0 to 1")


async def test_the_odd_clock_is_a_warning(deaf: tuple[Rig, Deaf]) -> None:
    rig, robot = deaf
    assert (await ready(rig))["clocks"] == {"name": "clocks", "state": "ready", "detail": "they agree"}
    now_s = robot._clock.now_s()
    for beat in range(20):
        for sensor, late_s in {"odom": 0.0, "scan": 0.0, "rgb": 7200.0}.items():
            robot.senses.clocks.moment(sensor, now_s + beat * 0.01 - late_s, now_s + beat * 0.01)
    clocks = (await ready(rig))["clocks"]
    assert clocks["state"] == "warning"
    assert "rgb is 2.0 h behind the others" in clocks["detail"]
