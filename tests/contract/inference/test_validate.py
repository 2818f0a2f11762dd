"""POST /validate: three votes on a fresh frame."""

import cv2
import numpy as np
import pytest

from contracts.colours import Colour
from contracts.vision import Detection, Validation
from support.inference_fakes import FakeClip, FakeLanguageModel, bottle, picture
from support.waiting import until

from .conftest import House, Opened

RED, BLUE = (20, 60, 60, 200), (150, 60, 190, 200)
SCENE = picture(("red", RED), ("blue", BLUE))
BOTH = (bottle(RED, 0.6), bottle(BLUE, 0.9))


def request(description: str, bbox: tuple[int, ...] | None = None, after: float | None = None) -> dict[str, object]:
    return {
        "target": {"label": "bottle", "description": description},
        "bbox_xyxy": bbox,
        "after_stamp_s": after,
    }


async def judged(house: House, opened: Opened, body: dict[str, object]) -> Validation:
    async with opened(house):
        house.camera.show(10.0, SCENE)
        await until(lambda: house.bus.published != [])
        answer = await house.client.post("/validate", json=body)
    assert answer.status_code == 200, answer.text
    return Validation.model_validate_json(answer.content)


def said(told: Validation) -> str:
    return " ".join(vote.verdict.value for vote in told.votes)


@pytest.fixture
def house() -> House:
    house = House()
    house.detector.found = BOTH
    return house


async def test_the_right_one_is_confirmed_by_detector_and_clip(house: House, opened: Opened) -> None:
    told = await judged(house, opened, request("red bottle", RED))
    assert (told.confirmed, said(told), told.bbox_xyxy, told.stamp_s) == (True, "yes yes abstain", RED, 10.0)
    clip = told.votes[1]
    assert (clip.threshold, clip.model, clip.score is not None) == (0.90, "fake-clip", True)


async def test_the_wrong_colour_is_refused(house: House, opened: Opened) -> None:
    told = await judged(house, opened, request("red bottle", BLUE))
    assert (told.confirmed, said(told), told.bbox_xyxy) == (False, "yes no abstain", BLUE)
    assert "but blue" in told.votes[1].reason


async def test_without_a_box_the_one_of_the_right_colour_is_judged(house: House, opened: Opened) -> None:
    told = await judged(house, opened, request("red bottle"))
    assert (told.confirmed, told.bbox_xyxy) == (True, RED)


async def test_a_thing_the_detector_does_not_see_is_not_confirmed(house: House, opened: Opened) -> None:
    house.detector.found = (Detection(label="cup", confidence=0.9, bbox_xyxy=RED),)
    told = await judged(house, opened, request("red bottle", RED))
    assert (told.confirmed, said(told)) == (False, "no yes abstain")


async def test_an_empty_frame_gets_two_noes(house: House, opened: Opened) -> None:
    house.detector.found = ()
    told = await judged(house, opened, request("red bottle"))
    assert (told.confirmed, said(told), told.bbox_xyxy) == (False, "no no abstain", None)


async def test_without_clip_the_detector_alone_confirms_nothing(house: House, opened: Opened) -> None:
    house.clip = None
    told = await judged(house, opened, request("red bottle", RED))
    assert (told.confirmed, said(told)) == (False, "yes abstain abstain")
    assert told.reason.startswith("only 1 of 3 could vote")


@pytest.mark.parametrize("bad", [np.nan, np.inf, 0.0])
async def test_clip_abstains_where_its_numbers_are_none(
    house: House, opened: Opened, monkeypatch: pytest.MonkeyPatch, bad: float
) -> None:
    monkeypatch.setattr(FakeClip, "embed_image", lambda self, crops: np.full((len(crops), 4), bad, np.float32))
    told = await judged(house, opened, request("red bottle", RED))
    assert (told.confirmed, said(told)) == (False, "yes abstain abstain")
    assert told.votes[1].reason == "clip: its embeddings are no unit vectors"


async def test_clip_abstains_on_a_colour_it_never_learnt(house: House, opened: Opened) -> None:
    house.clip._words.discard("red")
    told = await judged(house, opened, request("red bottle", RED))
    assert (said(told), told.votes[1].reason) == ("yes abstain abstain", "does not know the word red")


async def test_of_two_colours_asked_for_neither_speaks_against_the_other(house: House, opened: Opened) -> None:
    told = await judged(house, opened, request("blue and red bottle", RED))
    clip = told.votes[1]
    assert clip.rival not in {"", "blue", "red"}


async def test_clip_abstains_on_a_colour_it_has_no_picture_of(house: House, opened: Opened) -> None:
    house.clip.colours = (Colour.BLUE, Colour.GREEN)
    told = await judged(house, opened, request("red bottle", RED))
    assert told.votes[1].reason == "was never taught what red looks like"


async def test_words_clip_does_not_know_are_left_out_and_named(house: House, opened: Opened) -> None:
    told = await judged(house, opened, request("shiny red bottle", RED))
    assert told.confirmed
    assert "does not know shiny" in told.votes[1].reason


async def test_the_third_model_decides_where_the_two_disagree(house: House, opened: Opened) -> None:
    house.vlm = FakeLanguageModel(presence=True)
    told = await judged(house, opened, request("red bottle", BLUE))
    assert (told.confirmed, said(told), told.votes[2].reason) == (True, "yes no yes", "PRESENT: yes")


async def test_the_third_model_can_refuse(house: House, opened: Opened) -> None:
    house.vlm = FakeLanguageModel(presence=False)
    told = await judged(house, opened, request("red bottle", BLUE))
    assert (told.confirmed, said(told)) == (False, "yes no no")


async def test_the_third_model_is_not_asked_when_two_agree(house: House, opened: Opened) -> None:
    house.vlm = FakeLanguageModel()
    told = await judged(house, opened, request("red bottle", RED))
    assert (told.confirmed, house.vlm.asked, told.votes[2].reason) == (True, 0, "not asked: two already agree")


async def test_the_third_model_is_not_asked_of_a_robot_that_drives_on(house: House, opened: Opened) -> None:
    house.vlm = FakeLanguageModel(presence=True)
    told = await judged(house, opened, {**request("red bottle", BLUE), "moving": True})
    assert (told.confirmed, said(told), house.vlm.asked) == (False, "yes no abstain", 0)


@pytest.mark.parametrize(("mood", "word"), [({"hangs": True}, "deadline"), ({"away": True}, "not reachable")])
async def test_a_third_model_that_does_not_answer_abstains(
    house: House, opened: Opened, mood: dict[str, bool], word: str
) -> None:
    house.vlm = FakeLanguageModel(**mood)
    told = await judged(house, opened, request("red bottle", BLUE))
    assert (told.confirmed, said(told)) == (False, "yes no abstain")
    assert word in told.votes[2].reason


async def test_a_fresh_frame_is_waited_for(house: House, opened: Opened) -> None:
    async with opened(house, validate_frame_wait_s=3.0):
        house.camera.show(10.0, SCENE)
        await until(lambda: house.bus.published != [])
        late = await house.client.post("/validate", json=request("red bottle", RED, after=9.0))
        assert late.json()["stamp_s"] == 10.0


async def test_no_fresh_frame_in_time_is_a_timeout_that_names_the_camera(house: House, opened: Opened) -> None:
    async with opened(house):
        house.camera.show(10.0, SCENE)
        await until(lambda: house.bus.published != [])
        answer = await house.client.post("/validate", json=request("red bottle", RED, after=10.0))
    assert answer.status_code == 504
    assert "robot_bridge" in answer.json()["detail"]


@pytest.mark.parametrize(("excluded", "confirmed"), [("red", False), ("blue", True)])
async def test_a_colour_a_person_excluded_is_voted_down(
    house: House, opened: Opened, excluded: str, confirmed: bool
) -> None:
    target = {"label": "bottle", "description": "bottle", "not_colours": [excluded]}
    told = await judged(house, opened, request("bottle", RED) | {"target": target})
    assert told.confirmed is confirmed
    assert ("which was excluded" in told.votes[1].reason) is not confirmed


async def test_what_was_judged_can_be_looked_at_and_is_what_clip_was_shown(house: House, opened: Opened) -> None:
    async with opened(house):
        house.camera.show(10.0, SCENE)
        await until(lambda: house.bus.published != [])
        told = Validation.model_validate_json(
            (await house.client.post("/validate", json=request("red bottle", RED))).content
        )
        house.camera.show(11.0, picture(("blue", RED)))
        shown = await house.client.get(f"/validations/{told.id}.jpg")
        assert shown.headers["content-type"] == "image/jpeg"
        assert (await house.client.get("/validations/none.jpg")).status_code == 404
    crop = cv2.imdecode(np.frombuffer(shown.content, np.uint8), cv2.IMREAD_COLOR)
    blue, _, red = crop[crop.shape[0] // 2, crop.shape[1] // 2]
    assert crop.shape[1] < SCENE.shape[1]
    assert red > 150 > blue


async def test_each_vote_tells_what_it_is_worth_where_its_model_was_measured(house: House, opened: Opened) -> None:
    house.detector.name = "detector"
    detector, clip, _ = (await judged(house, opened, request("blue bottle", BLUE))).votes
    assert detector.log_odds is not None
    assert 0.0 < detector.log_odds < 1.0
    assert clip.log_odds is None


async def test_a_frame_after_a_time_that_is_none_is_refused_here_and_not_asked_of_the_camera(
    house: House, opened: Opened
) -> None:
    async with opened(house):
        answer = await house.client.post("/validate", json=request("red bottle", after=-1.0))
    assert answer.status_code == 422, answer.text
