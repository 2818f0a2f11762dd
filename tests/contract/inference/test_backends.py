"""A detector that is quickened while it works: first on its weights, then on the export that was made meanwhile."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field

from contracts.vision import Detections, ModelInfo, ModelState
from inference.perception.models import Loaded
from support.inference_fakes import FakeClip, FakeDetector, bottle, jpeg_of, picture
from support.waiting import until

from .conftest import House, Opened

BODY = jpeg_of(picture())


@dataclass
class Faster:
    """An export that takes as long as the test says."""

    trouble: str = ""
    made: asyncio.Event = field(default_factory=asyncio.Event)
    asked: int = 0

    async def prepare(self) -> str:
        self.asked += 1
        await self.made.wait()
        return self.trouble

    def load(self) -> FakeDetector:
        return FakeDetector((bottle(),), backend="openvino", backends_ms={"torch": 30.0, "openvino": 9.0})


def house_with(faster: Faster) -> House:
    return House(load=lambda: Loaded(detector=FakeDetector(backend="torch"), clip=FakeClip(), faster=faster))


async def detector_of(house: House) -> ModelInfo:
    told = [ModelInfo.model_validate(one) for one in (await house.client.get("/models")).json()]
    return next(one for one in told if one.role == "detector")


async def detector_once(house: House, wanted: Callable[[ModelInfo], bool]) -> ModelInfo:
    async with asyncio.timeout(30.0):
        while True:
            told = await detector_of(house)
            if wanted(told):
                return told
            await asyncio.sleep(0.01)


async def seen(house: House) -> int:
    answer = await house.client.post("/detect", content=BODY)
    return len(Detections.model_validate_json(answer.content).detections)


async def test_it_works_on_its_weights_until_the_export_is_made(opened: Opened) -> None:
    faster = Faster()
    async with opened(house_with(faster)) as house:
        await house.until_loaded()
        await until(lambda: faster.asked == 1)
        assert ((await detector_of(house)).backend, await seen(house)) == ("torch", 0)
        faster.made.set()
        told = await detector_once(house, lambda one: one.backend == "openvino")
        assert await seen(house) == 1
    assert (told.backend, told.backends_ms, told.detail) == ("openvino", {"torch": 30.0, "openvino": 9.0}, "")


async def test_an_export_that_cannot_be_made_is_told_and_the_weights_serve_on(opened: Opened) -> None:
    faster = Faster(trouble="openvino needs the package openvino")
    faster.made.set()
    async with opened(house_with(faster)) as house:
        await house.until_loaded()
        told = await detector_once(house, lambda one: one.detail != "")
        assert (told.backend, told.state, told.detail) == (
            "torch",
            ModelState.READY,
            "openvino needs the package openvino",
        )
        assert (await house.client.post("/detect", content=BODY)).status_code == 200


async def test_leaving_while_an_export_is_made_leaves_at_once(opened: Opened) -> None:
    faster = Faster()
    async with opened(house_with(faster)) as house:
        await house.until_loaded()
        await until(lambda: faster.asked == 1)
