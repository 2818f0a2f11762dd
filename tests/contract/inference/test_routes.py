"""The routes: what they answer, and how they refuse."""

import io
import threading
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from PIL import Image

from contracts.problem import Problem
from contracts.vision import Detections, EmbedReply, ModelInfo, ModelState, ScoreReply
from inference.perception.models import Loaded
from support.inference_fakes import POSE, FakeClip, FakeLanguageModel, bottle, jpeg_of, loads, picture
from support.waiting import until

from .conftest import House, Opened

SCENE = picture(("red", (80, 60, 130, 200)))


async def test_an_image_sent_is_looked_at(opened: Opened) -> None:
    async with opened() as house:
        answer = await house.client.post("/detect", content=jpeg_of(SCENE), headers={"content-type": "image/jpeg"})
    told = Detections.model_validate_json(answer.content)
    assert (answer.status_code, told.image_width_px, told.pose) == (200, 250, None)
    assert told.detections[0].label == "bottle"


async def test_without_an_image_the_newest_frame_is_looked_at(opened: Opened) -> None:
    async with opened() as house:
        house.camera.show(12.5, SCENE)
        answer = await house.client.post("/detect")
    told = Detections.model_validate_json(answer.content)
    assert (told.stamp_s, told.pose) == (12.5, POSE)


@pytest.mark.parametrize(
    ("body", "status", "word"),
    [
        (b"hello", 422, "neither"),
        (jpeg_of(SCENE)[:2000], 422, "truncated"),
        (b"x" * 10_000_001, 413, "10000000"),
    ],
)
async def test_a_bad_image_is_a_clear_problem(opened: Opened, body: bytes, status: int, word: str) -> None:
    async with opened() as house:
        answer = await house.client.post("/detect", content=body, headers={"content-type": "image/jpeg"})
    told = Problem.model_validate_json(answer.content)
    assert (answer.status_code, answer.headers["content-type"]) == (status, "application/problem+json")
    assert word in told.detail


async def test_texts_are_scored_against_the_box(opened: Opened) -> None:
    async with opened() as house:
        house.camera.show(1.0, SCENE)
        body = {"texts": ["red bottle", "blue bottle"], "bbox_xyxy": [80, 60, 130, 200]}
        answer = await house.client.post("/clip-score", json=body)
    told = ScoreReply.model_validate_json(answer.content)
    assert told.scores[0] > 0.95 > told.scores[1]
    assert (told.threshold, told.model) == (0.90, "fake-clip")


async def test_embeddings_are_unit_vectors_in_the_order_sent(opened: Opened) -> None:
    async with opened() as house:
        house.camera.show(1.0, SCENE)
        body = {"texts": ["red", "blue", "red"], "image": True, "bbox_xyxy": [80, 60, 130, 200]}
        told = EmbedReply.model_validate_json((await house.client.post("/embed", json=body)).content)
        alone = EmbedReply.model_validate_json((await house.client.post("/embed", json={"texts": []})).content)
    assert told.image is not None
    assert sum(v * v for v in told.image) == pytest.approx(1.0, abs=1e-3)
    assert told.texts[0] == told.texts[2] != told.texts[1]
    assert (alone.image, alone.texts) == (None, ())


@pytest.mark.parametrize(
    ("path", "body"),
    [
        ("/clip-score", {"texts": []}),
        ("/clip-score", {"texts": ["x" * 201]}),
        ("/clip-score", {"texts": ["red"], "bbox_xyxy": [10, 10, 5, 20]}),
        ("/validate", {"target": {"label": "bottle"}}),
        ("/validate", {"target": {"label": "bottle", "description": "b"}, "bbox_xyxy": [5, 5, 5, 5]}),
        ("/parse-task", {"command": ""}),
        ("/parse-task", {"command": "x" * 501}),
        ("/parse-task", {"command": "find it", "more": 1}),
        ("/embed", {"texts": ["x" * 201]}),
    ],
)
async def test_a_malformed_request_is_refused(opened: Opened, path: str, body: dict[str, Any]) -> None:
    async with opened() as house:
        house.camera.show(1.0, SCENE)
        answer = await house.client.post(path, json=body)
    assert (answer.status_code, answer.headers["content-type"]) == (422, "application/problem+json")


async def test_without_a_camera_the_answer_names_it(opened: Opened) -> None:
    house = House()
    house.camera.away = True
    async with opened(house):
        await until(lambda: house.camera.asked > 0)
        answer = await house.client.post("/detect")
    assert answer.status_code == 503
    assert "robot_bridge" in answer.json()["detail"]


async def test_health_answers_while_models_load_and_ready_says_so(opened: Opened) -> None:
    may_load = threading.Event()

    def load() -> Loaded:
        may_load.wait(10.0)
        return Loaded()

    async with opened(House(load=load)) as house:
        assert (await house.client.get("/health")).status_code == 200
        ready = (await house.client.get("/ready")).json()
        assert ready["dependencies"][0] == {"name": "models", "state": "not_ready", "detail": "loading"}
        answer = await house.client.post("/detect", content=b"x")
        assert (answer.status_code, answer.json()["detail"]) == (503, "models: still loading")
        may_load.set()


async def test_models_that_cannot_be_loaded_are_named(opened: Opened) -> None:
    house = House(load=loads(problems=("detector: no detector weights at nowhere.pt",)))
    async with opened(house):
        ready = await house.until_loaded()
        assert "nowhere.pt" in ready["dependencies"][0]["detail"]
        told = [ModelInfo.model_validate(one) for one in (await house.client.get("/models")).json()]
        assert (await house.client.post("/clip-score", json={"texts": ["a"]})).status_code == 503
    assert [(one.role, one.state) for one in told][:3] == [
        ("detector", ModelState.NOT_LOADED),
        ("clip", ModelState.NOT_LOADED),
        ("vlm", ModelState.NOT_CONFIGURED),
    ]


async def test_models_are_listed_with_their_thresholds(opened: Opened) -> None:
    house = House(vlm=FakeLanguageModel(), language_model=FakeLanguageModel())
    async with opened(house):
        told = [ModelInfo.model_validate(one) for one in (await house.client.get("/models")).json()]
    assert [(one.role, one.name, one.threshold) for one in told] == [
        ("detector", "fake-detector", 0.30),
        ("clip", "fake-clip", 0.90),
        ("vlm", "fake:llm", None),
        ("parser", "fake:llm", None),
        ("parser", "rules", None),
    ]


async def test_more_callers_than_may_wait_are_told_to_come_back(opened: Opened) -> None:
    entered, go_on = threading.Event(), threading.Event()
    house = House()

    class Slow(type(house.detector)):
        def detect(self, image: Any) -> Any:
            entered.set()
            go_on.wait(10.0)
            return (bottle(),)

    house.detector = Slow()
    async with opened(house, waiting_max=1):
        house.camera.show(1.0, SCENE)
        await until(entered.is_set)
        answer = await house.client.post("/detect", content=jpeg_of(SCENE))
        go_on.set()
    assert (answer.status_code, answer.headers["retry-after"]) == (429, "1")


def encoded(image: Image.Image, kind: str, **more: Any) -> bytes:
    buffer = io.BytesIO()
    image.save(buffer, kind, **more)
    return buffer.getvalue()


def turned() -> bytes:
    exif = Image.Exif()
    exif[0x0112] = 6  # the camera was held upright
    return encoded(Image.new("RGB", (64, 32)), "JPEG", exif=exif)


def animated() -> bytes:
    return encoded(Image.new("RGB", (8, 8)), "PNG", save_all=True, append_images=[Image.new("RGB", (8, 8), "red")])


@pytest.mark.parametrize(
    ("body", "status", "word"),
    [
        (encoded(Image.new("CMYK", (8, 8)), "JPEG"), 422, "CMYK"),
        (encoded(Image.new("I;16", (8, 8)), "PNG"), 422, "16 bits"),
        (animated(), 422, "animated"),
        (encoded(Image.new("RGB", (8, 8)), "GIF"), 422, "neither"),
        (encoded(Image.new("L", (4097, 1)), "PNG"), 413, "4096"),
    ],
)
async def test_an_image_that_no_camera_sends_is_refused_by_name(
    opened: Opened, body: bytes, status: int, word: str
) -> None:
    async with opened() as house:
        answer = await house.client.post("/detect", content=body)
    assert (answer.status_code, answer.headers["content-type"]) == (status, "application/problem+json")
    assert word in answer.json()["detail"]


@pytest.mark.parametrize(
    ("body", "size_px"),
    [
        (turned(), (32, 64)),
        (encoded(Image.new("L", (50, 40)), "JPEG"), (50, 40)),
        (encoded(Image.new("RGBA", (50, 40)), "PNG"), (50, 40)),
        (encoded(Image.new("P", (50, 40)), "PNG"), (50, 40)),
    ],
)
async def test_an_unusual_image_is_seen_as_a_person_would_see_it(
    opened: Opened, body: bytes, size_px: tuple[int, int]
) -> None:
    async with opened() as house:
        answer = await house.client.post("/detect", content=body)
    told = Detections.model_validate_json(answer.content)
    assert (told.image_width_px, told.image_height_px) == size_px


async def test_texts_are_scored_against_the_crop_and_the_frame_at_once(opened: Opened) -> None:
    async with opened() as house:
        house.camera.show(1.0, SCENE)
        body: dict[str, Any] = {"texts": ["red bottle", "blue bottle", "bottle"]}
        whole = ScoreReply.model_validate_json((await house.client.post("/clip-score", json=body)).content)
        body["bbox_xyxy"] = [80, 60, 130, 200]
        both = ScoreReply.model_validate_json((await house.client.post("/clip-score", json=body)).content)
    assert (len(whole.scores), whole.frame_scores) == (3, ())
    assert both.frame_scores == pytest.approx(whole.scores)
    assert both.scores[0] > both.scores[1]


async def test_embeddings_that_are_none_are_not_handed_out(opened: Opened, monkeypatch: pytest.MonkeyPatch) -> None:
    nothing = np.full((1, 4), np.nan, np.float32)
    async with opened() as house:
        house.camera.show(10.0, picture())
        monkeypatch.setattr(FakeClip, "embed_text", lambda self, texts: nothing)
        said = [await house.client.post(f"/{path}", json={"texts": ["red cup"]}) for path in ("embed", "clip-score")]
        monkeypatch.undo()
        again = await house.client.post("/embed", json={"texts": ["red cup"]})
    assert [(one.status_code, one.json()["detail"]) for one in said] == [
        (503, "clip: its embeddings are no unit vectors")
    ] * 2
    assert again.status_code == 200


async def test_a_text_is_embedded_once(opened: Opened) -> None:
    house = House()
    asked: list[str] = []

    class Counting(type(house.clip)):
        def embed_text(self, texts: Sequence[str]) -> Any:
            asked.extend(texts)
            return super().embed_text(texts)

    house.clip = Counting()
    async with opened(house):
        for _ in range(3):
            await house.client.post("/embed", json={"texts": ["shiny", "red", "shiny"]})
    assert sorted(asked) == ["red", "shiny"]
