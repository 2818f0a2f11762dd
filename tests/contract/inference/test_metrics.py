"""What inference tells Prometheus of its eyes."""

from contracts.topics import VISION_DETECTIONS
from support.inference_fakes import picture
from support.scraped import sample, scraped, untold
from support.waiting import until

from .conftest import Opened


async def test_a_look_leaves_its_time_and_the_age_of_its_frame(opened: Opened) -> None:
    async with opened() as house:
        before = sample(await scraped(house.client), "inference_look_seconds_count")
        house.camera.show(10.0, picture(("red", (80, 60, 130, 200))))
        await until(lambda: house.bus.of(VISION_DETECTIONS) != [])
        told = await scraped(house.client)
    assert sample(told, "inference_look_seconds_count") > before
    assert untold(told, "inference") == set()
