"""The perception loop through the front door: what it tells, what it draws, and what it survives."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import pytest

from contracts.mission import MissionTarget
from contracts.problem import DependencyState, Readiness
from contracts.topics import MISSION_TARGET, VISION_DETECTIONS, VISION_OBJECT_SPOTTED
from contracts.vision import Detection, Target
from inference.ports import Embeddings, Frame, RgbImage
from mesh.errors import UnavailableError
from mesh.tracing import following
from support.inference_fakes import POSE, FakeCamera, FakeClip, FakeDetector, bottle, picture
from support.waiting import until

from .conftest import RED_BOTTLE, House, Opened

RED_THING = ("red", (80, 60, 130, 200))
BLUE_THING = ("blue", (80, 60, 130, 200))


async def test_each_frame_is_told_with_its_own_stamp_pose_and_size(opened: Opened) -> None:
    async with opened() as house:
        house.camera.show(10.0, picture(RED_THING))
        await until(lambda: house.bus.of(VISION_DETECTIONS) != [])
    (told,) = house.bus.of(VISION_DETECTIONS)
    assert (told.stamp_s, told.pose, told.image_width_px, told.image_height_px) == (10.0, POSE, 250, 250)
    (one,) = told.detections
    assert one.model_copy(update={"measurement": None}) == bottle().model_copy(update={"colour": "red"})
    assert told.model == "fake-detector"


async def test_all_boxes_of_a_frame_are_measured_by_one_call_and_told_with_their_places(opened: Opened) -> None:
    house = House(detector=FakeDetector((bottle(), bottle((10.0, 60.0, 40.0, 200.0)))))
    async with opened(house):
        house.camera.show(10.0, picture(RED_THING))
        await until(lambda: house.bus.of(VISION_DETECTIONS) != [])
    (told,) = house.bus.of(VISION_DETECTIONS)
    assert [one.measurement.distance_m for one in told.detections if one.measurement] == [1.0, 2.0]
    (request,) = house.camera.localized
    assert (request.stamp_s, request.image_width_px) == (10.0, 250)
    assert request.boxes_xyxy == tuple(one.bbox_xyxy for one in told.detections)


@pytest.mark.parametrize("trouble", ["localize_fails", "localize_hangs"])
async def test_without_places_the_detections_go_out_all_the_same(opened: Opened, trouble: str) -> None:
    house = House()
    setattr(house.camera, trouble, True)
    async with opened(house):
        house.camera.show(10.0, picture(RED_THING))
        await until(lambda: house.bus.of(VISION_DETECTIONS) != [])
    (told,) = house.bus.of(VISION_DETECTIONS)
    (one,) = told.detections
    assert one.measurement is not None
    assert (one.measurement.answered, one.measurement.distance_m) == (False, None)


async def test_however_long_a_proxys_answer_is_the_detections_go_out(opened: Opened) -> None:
    house = House()
    house.camera.localize_fails = True
    house.camera.detail = "page " * 300
    async with opened(house):
        house.camera.show(10.0, picture(RED_THING))
        await until(lambda: house.bus.of(VISION_DETECTIONS) != [])
    (told,) = house.bus.of(VISION_DETECTIONS)
    assert told.detections[0].measurement is not None
    assert told.detections[0].measurement.text == ("page " * 300)[:500]


async def test_a_frame_that_shows_nothing_is_not_measured(opened: Opened) -> None:
    house = House(detector=FakeDetector())
    async with opened(house):
        house.camera.show(10.0, picture())
        await until(lambda: house.bus.of(VISION_DETECTIONS) != [])
    assert house.camera.localized == []


async def test_the_same_frame_is_never_told_twice(opened: Opened) -> None:
    async with opened() as house:
        house.camera.show(10.0, picture(RED_THING))
        await until(lambda: house.camera.asked >= 4)
    assert len(house.bus.of(VISION_DETECTIONS)) == 1


async def test_the_target_is_announced_at_most_every_half_second(opened: Opened) -> None:
    house = House()
    await house.look_for(RED_BOTTLE)
    async with opened(house):
        for stamp_s in (10.0, 10.2, 10.4, 10.5, 10.7, 11.1):
            house.camera.show(stamp_s, picture(RED_THING))
            await house.until_drawn(stamp_s)
    spotted = house.bus.of(VISION_OBJECT_SPOTTED)
    assert [one.stamp_s for one in spotted] == [10.0, 10.5, 11.1]
    assert (spotted[0].target, spotted[0].detection.colour, spotted[0].pose) == (RED_BOTTLE, "red", POSE)


async def test_the_same_kind_in_another_colour_is_not_announced(opened: Opened) -> None:
    house = House()
    await house.look_for(RED_BOTTLE)
    async with opened(house):
        house.camera.show(10.0, picture(BLUE_THING))
        await house.until_drawn(10.0)
        await house.look_for(Target(label="bottle", description="bottle"))
        for stamp_s in (20.0, 30.0):
            house.camera.show(stamp_s, picture(BLUE_THING))
            await house.until_drawn(stamp_s)
    spotted = house.bus.of(VISION_OBJECT_SPOTTED)
    assert spotted[-1].stamp_s == 30.0
    assert {one.target.description for one in spotted} == {"bottle"}


async def test_nothing_is_announced_while_nothing_is_looked_for(opened: Opened) -> None:
    async with opened() as house:
        house.camera.show(10.0, picture(RED_THING))
        await house.until_drawn(10.0)
    assert house.bus.of(VISION_OBJECT_SPOTTED) == []


async def test_it_resumes_when_the_bridge_and_redis_return(opened: Opened) -> None:
    house = House()
    house.camera.away = True
    house.bus.connected = False
    async with opened(house):
        await until(lambda: house.camera.asked >= 1)
        ready = (await house.client.get("/ready")).json()
        assert [one["state"] for one in ready["dependencies"]] == ["ready", "not_ready", "unreachable"]
        assert "robot_bridge" in ready["dependencies"][1]["detail"]
        house.camera.away, house.bus.connected = False, True
        house.camera.show(10.0, picture())
        await until(lambda: house.bus.of(VISION_DETECTIONS) != [])
        assert (await house.client.get("/ready")).status_code == 200


async def test_a_damaged_frame_is_passed_over(opened: Opened) -> None:
    async with opened() as house:
        house.camera.show(10.0, b"\xff\xd8 half a pict")
        await until(lambda: house.camera.asked >= 2)
        house.camera.show(11.0, picture())
        await until(lambda: house.bus.of(VISION_DETECTIONS) != [])
    assert [one.stamp_s for one in house.bus.of(VISION_DETECTIONS)] == [11.0]


@dataclass
class FailingDetector(FakeDetector):
    """Cannot look at the first pictures, and finds what is no box in the others."""

    fails: int = 2

    def detect(self, image: RgbImage) -> tuple[Detection, ...]:
        if len(self.sizes) < self.fails:
            self.sizes.append((0, 0))
            raise UnavailableError("detector", "could not look at a picture: out of memory")
        self.trouble = "of its boxes some were none: 1 not finite"
        return super().detect(image)


async def test_a_picture_the_detector_fails_on_is_not_told_as_an_empty_one(opened: Opened) -> None:
    async with opened(House(detector=FailingDetector((bottle(),)))) as house:
        house.camera.show(10.0, picture())
        await until(lambda: len(house.detector.sizes) == 1)
        house.camera.show(11.0, picture())
        await until(lambda: len(house.detector.sizes) == 2)
        house.camera.show(12.0, picture())
        await until(lambda: house.bus.of(VISION_DETECTIONS) != [])
        ready = Readiness.model_validate_json((await house.client.get("/ready")).content)
    assert [one.stamp_s for one in house.bus.of(VISION_DETECTIONS)] == [12.0]
    assert (ready.ready, ready.dependencies[0].state) == (True, DependencyState.WARNING)
    assert ready.dependencies[0].detail == "of its boxes some were none: 1 not finite"


class NonsenseClip(FakeClip):
    """The first crop of each picture comes out as no number."""

    def embed_image(self, crops: Sequence[RgbImage]) -> Embeddings:
        found = super().embed_image(crops)
        found[0] = np.nan
        return found


async def test_numbers_that_are_none_cost_a_box_its_colour(opened: Opened) -> None:
    house = House(clip=NonsenseClip())
    house.detector.found = (bottle((20, 60, 60, 200), 0.9), bottle((150, 60, 190, 200), 0.8))
    async with opened(house):
        house.camera.show(10.0, picture(("red", (20, 60, 60, 200)), ("blue", (150, 60, 190, 200))))
        await until(lambda: house.bus.of(VISION_DETECTIONS) != [])
        ready = Readiness.model_validate_json((await house.client.get("/ready")).content)
    (seen,) = house.bus.of(VISION_DETECTIONS)
    assert [one.colour for one in seen.detections] == [None, "blue"]
    assert ready.dependencies[0].detail == "clip: its embeddings are no unit vectors"


async def test_a_robot_whose_clock_started_again_is_seen_again(opened: Opened) -> None:
    async with opened(clock_restarted_after_s=0.3) as house:
        house.camera.show(1000.0, picture())
        await until(lambda: house.bus.of(VISION_DETECTIONS) != [])
        house.camera.show(1.0, picture())
        await until(lambda: len(house.bus.of(VISION_DETECTIONS)) == 2)
    assert [one.stamp_s for one in house.bus.of(VISION_DETECTIONS)] == [1000.0, 1.0]


async def test_boxes_are_in_pixels_of_the_frame_also_when_the_detector_gets_a_smaller_one(opened: Opened) -> None:
    house = House()
    async with opened(house, frame_width_px=125):
        house.camera.show(10.0, picture(RED_THING))
        await until(lambda: house.bus.of(VISION_DETECTIONS) != [])
    assert house.detector.sizes == [(125, 125)]
    (told,) = house.bus.of(VISION_DETECTIONS)
    assert told.image_width_px == 250
    assert told.detections[0].bbox_xyxy == (160.0, 120.0, 260.0, 400.0)


async def test_the_rate_follows_the_mission(opened: Opened) -> None:
    async with opened(rest_rate_hz=0.01, fast_rate_hz=60.0) as house:
        house.camera.show(10.0, picture())
        await until(lambda: len(house.bus.of(VISION_DETECTIONS)) == 1)
        house.camera.show(11.0, picture())
        await house.look_for(RED_BOTTLE, fast=True)
        await until(lambda: len(house.bus.of(VISION_DETECTIONS)) == 2)  # at the rate of rest: in 100 s


async def test_the_annotated_frame_is_waited_for_and_carries_its_stamp(opened: Opened) -> None:
    async with opened() as house:
        assert (await house.client.get("/annotated", params={"wait_s": 0.01})).status_code == 204
        await house.look_for(RED_BOTTLE)
        house.camera.show(10.0, picture(RED_THING))
        first = await house.client.get("/annotated", params={"wait_s": 5})
        assert (first.status_code, float(first.headers["x-stamp-s"])) == (200, 10.0)
        image = cv2.imdecode(np.frombuffer(first.content, np.uint8), cv2.IMREAD_COLOR)
        assert image.shape[1] == 500
        again = await house.client.get("/annotated", params={"after": 10.0, "wait_s": 0.01})
        assert again.status_code == 204
        house.camera.show(11.0, picture())
        later = await house.client.get("/annotated", params={"after": 10.0, "wait_s": 5})
        assert float(later.headers["x-stamp-s"]) == 11.0


async def test_only_so_many_may_watch_the_stream(opened: Opened) -> None:
    async with opened(stream_viewers_max=0) as house:
        answer = await house.client.get("/annotated/stream")
    assert (answer.status_code, answer.headers["content-type"]) == (429, "application/problem+json")


class AskedCamera(FakeCamera):
    """Remembers after which stamp a frame was asked for."""

    def __init__(self) -> None:
        super().__init__()
        self.after_s: list[float | None] = []

    async def newest(self, *, after_s: float | None, wait_s: float) -> Frame | None:
        self.after_s.append(after_s)
        return await super().newest(after_s=after_s, wait_s=wait_s)


async def test_a_frame_is_asked_for_as_it_is_due_so_that_it_is_not_old_when_it_is_seen(opened: Opened) -> None:
    camera = AskedCamera()
    async with opened(House(camera=camera), rest_rate_hz=4.0, frame_wait_s=5.0) as house:
        camera.show(10.0, picture())
        await until(lambda: len(camera.after_s) == 2)
        camera.show(10.1, picture())  # not due yet
        await house.client.get("/health")  # time for whoever waits
        camera.show(10.25, picture())
        await until(lambda: len(house.bus.of(VISION_DETECTIONS)) == 2)
    assert camera.after_s[:2] == [None, pytest.approx(10.0 + 0.25 - 0.02)]
    assert [one.stamp_s for one in house.bus.of(VISION_DETECTIONS)] == [10.0, 10.25]


async def test_after_a_round_without_a_frame_any_newer_one_will_do(opened: Opened) -> None:
    camera = AskedCamera()
    async with opened(House(camera=camera), rest_rate_hz=4.0, frame_wait_s=0.05) as house:
        camera.show(10.0, picture())
        await until(lambda: 10.0 in camera.after_s)
        camera.show(10.1, picture())
        await until(lambda: len(house.bus.of(VISION_DETECTIONS)) == 2)
    assert [one.stamp_s for one in house.bus.of(VISION_DETECTIONS)] == [10.0, 10.1]


async def test_looks_belong_to_the_trace_that_asks_for_the_target_while_one_does(opened: Opened) -> None:
    parent = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-00"
    async with opened() as house:
        with following(parent):
            await house.bus.publish(MISSION_TARGET, MissionTarget(target=RED_BOTTLE, mission_id="m1"))
        await until(lambda: house.bus.idle(MISSION_TARGET))
        house.camera.show(10.0, picture(RED_THING))
        await until(lambda: len(house.bus.of(VISION_DETECTIONS)) == 1)
        await house.bus.publish(MISSION_TARGET, MissionTarget())
        await until(lambda: house.bus.idle(MISSION_TARGET))
        house.camera.show(11.0, picture(RED_THING))
        await until(lambda: len(house.bus.of(VISION_DETECTIONS)) == 2)
    assert [said[3:35] for said in house.bus.said_in(VISION_DETECTIONS)] == [parent[3:35], ""]
