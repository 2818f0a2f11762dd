"""'Not the blue one': a thing whose colour was excluded is no candidate, and is told as seen instead."""

import pytest

from contracts.colours import Colour
from contracts.vision import Detection, Detections, ParsedTarget, Target
from coordinator.core.mission import Mission
from coordinator.core.report import count_objects_in
from coordinator.core.sightings import sightings
from coordinator.queue.parse_validation import check_parse
from support.mission_script import rules_of

WANTED = Target(label="bottle", description="bottle", not_colours=(Colour.BLUE, Colour.GREY))


def frame(*colours: Colour | None) -> Detections:
    boxes = [
        Detection(label="bottle", confidence=0.8, bbox_xyxy=(10.0, 10.0, 60.0, 90.0), colour=one) for one in colours
    ]
    return Detections(stamp_s=1.0, image_width_px=320, image_height_px=240, detections=tuple(boxes))


@pytest.mark.parametrize(("colour", "taken"), [(Colour.BLUE, 0), (Colour.GREY, 0), (Colour.RED, 1), (None, 1)])
def test_only_a_thing_of_another_or_no_known_colour_is_a_candidate(colour: Colour | None, taken: int) -> None:
    mission = Mission(rules=rules_of(), target=WANTED)
    assert len(sightings(mission, frame(colour))) == taken


def test_what_was_excluded_is_told_as_seen_instead() -> None:
    others = count_objects_in((), WANTED, frame(Colour.BLUE, Colour.RED, None))
    assert [(one.label, one.colour) for one in others] == [("bottle", "blue")]


@pytest.mark.parametrize(
    ("command", "excluded"),
    [
        ("find the bottle, not the blue one", ("blue",)), ("a bottle which is neither red nor gray", ("red", "grey")),
        ("any bottle except the green ones", ("green",)), ("find the blue bottle", ()),
        ("find the red bottle, not the blue one", ("blue",)), ("not the red bottle, the red one", ()),
    ],
)  # fmt: skip
def test_a_colour_is_excluded_by_the_persons_words_whoever_read_them(command: str, excluded: tuple[str, ...]) -> None:
    colour = "red " if "red" in command and "neither" not in command else ""
    parsed = ParsedTarget(said=command, yolo_class="bottle", description=f"{colour}bottle", parser="ollama:test")
    task = check_parse(parsed, ())
    assert task is not None
    assert task.target.not_colours == excluded
