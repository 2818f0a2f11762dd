"""The committed weights vote through the front door on a rendered bottle: red passes for red, blue does not."""

from collections.abc import AsyncIterator

import httpx
import pytest
from asgi_lifespan import LifespanManager

from contracts.vision import Target, Validation, Verdict
from inference.app import create_app
from inference.ports import RgbImage
from inference.settings import Backend, Settings
from support.bus import MemoryBus
from support.inference_fakes import FakeCamera
from support.rendered_bottle import BottleScene, bottle_scene
from support.source import ROOT
from support.waiting import until

UNSEEN_SEEDS = (900_101, 900_102)
WEIGHTS = ROOT / "sim/weights"


@pytest.fixture(scope="module", params=UNSEEN_SEEDS)
def scene(request: pytest.FixtureRequest) -> BottleScene:
    return bottle_scene(request.param)


class Service:
    """The real service with the committed weights, behind a camera that shows what it is told."""

    def __init__(self, client: httpx.AsyncClient, camera: FakeCamera) -> None:
        self.client, self.camera, self.stamp_s = client, camera, 0.0

    async def judge(self, picture: RgbImage, description: str, scene: BottleScene) -> Validation:
        self.stamp_s += 1.0
        self.camera.show(self.stamp_s, picture)
        target = Target(label="bottle", description=description)
        body = {"target": target.model_dump(), "bbox_xyxy": scene.box.bbox_xyxy, "after_stamp_s": self.stamp_s - 0.5}
        answer = await self.client.post("/validate", json=body)
        assert answer.status_code == 200, answer.text
        return Validation.model_validate_json(answer.content)


@pytest.fixture
async def service() -> AsyncIterator[Service]:
    settings = Settings(
        detector_path=WEIGHTS / "detector.pt",
        detector_backend=Backend.TORCH,
        clip_path=WEIGHTS / "clip.safetensors",
        validate_frame_wait_s=10.0,
    )
    camera, deaths = FakeCamera(), list[str]()
    app = create_app(settings, bus=MemoryBus(), camera=camera, on_death=lambda: deaths.append("a task died"))
    async with (
        LifespanManager(app, startup_timeout=60.0) as managed,
        httpx.AsyncClient(transport=httpx.ASGITransport(managed.app), base_url="http://inference") as client,
    ):
        await until(lambda: camera.asked > 0, timeout_s=60.0)  # the models are loaded
        yield Service(client, camera)
    assert deaths == []


async def test_a_red_bottle_is_confirmed_and_the_same_in_blue_refused(service: Service, scene: BottleScene) -> None:
    red = await service.judge(scene.picture("red"), "red bottle", scene)
    blue = await service.judge(scene.picture("blue"), "red bottle", scene)
    assert red.confirmed, red.reason
    assert [vote.verdict for vote in red.votes[:2]] == [Verdict.YES, Verdict.YES]
    assert not blue.confirmed
    assert [vote.verdict for vote in blue.votes[:2]] == [Verdict.YES, Verdict.NO]
    assert blue.votes[1].rival == "blue"


async def test_what_is_asked_decides_not_what_stands_there(service: Service, scene: BottleScene) -> None:
    blue = await service.judge(scene.picture("blue"), "blue bottle", scene)
    plain = await service.judge(scene.picture("blue"), "bottle", scene)
    assert (blue.confirmed, plain.confirmed) == (True, True)
