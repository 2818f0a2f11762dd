"""The arithmetic behind scores.json, on boxes small enough to check by hand."""

import pytest

from geometry.boxes import iou
from sim.training.records import Box, Frame, from_json, to_json, yolo_lines
from sim.training.scores import Guess, average_precision, match, recall, recall_by_distance


def box(kind: str, bbox: tuple[int, int, int, int], distance_m: float = 1.0) -> Box:
    return Box("thing", kind, "red", bbox, distance_m, 100)


def frame(*boxes: Box) -> Frame:
    return Frame("images/a.jpg", 900000, boxes)


def test_two_halves_overlap_by_a_third() -> None:
    assert iou((0, 0, 2, 1), (1, 0, 3, 1)) == pytest.approx(1 / 3)


def test_boxes_apart_do_not_overlap() -> None:
    assert iou((0, 0, 1, 1), (5, 5, 6, 6)) == 0.0


def test_perfect_guesses_have_a_precision_of_one() -> None:
    frames = [frame(box("cup", (0, 0, 10, 10)), box("cup", (50, 50, 60, 60)))]
    guesses = [[Guess("cup", 0.9, (0, 0, 10, 10)), Guess("cup", 0.8, (50, 50, 60, 60))]]
    assert average_precision(match(frames, guesses), "cup") == pytest.approx(1.0)


def test_a_surer_wrong_guess_halves_the_precision() -> None:
    frames = [frame(box("cup", (0, 0, 10, 10)))]
    guesses = [[Guess("cup", 0.9, (100, 100, 120, 120)), Guess("cup", 0.8, (0, 0, 10, 10))]]
    assert average_precision(match(frames, guesses), "cup") == pytest.approx(0.5)


def test_a_guess_of_another_kind_finds_nothing() -> None:
    matches = match([frame(box("cup", (0, 0, 10, 10)))], [[Guess("bowl", 0.9, (0, 0, 10, 10))]])
    assert recall(matches.truths, 0.3) == 0.0


def test_one_label_is_hit_only_once() -> None:
    frames = [frame(box("cup", (0, 0, 10, 10)))]
    guesses = [[Guess("cup", 0.9, (0, 0, 10, 10)), Guess("cup", 0.8, (0, 0, 10, 10))]]
    assert [right for _, _, right in match(frames, guesses).guesses] == [True, False]


def test_recall_is_told_for_each_ring_of_distance() -> None:
    frames = [frame(box("cup", (0, 0, 10, 10), 0.5), box("cup", (50, 50, 60, 60), 3.0))]
    matches = match(frames, [[Guess("cup", 0.9, (0, 0, 10, 10))]])
    assert recall_by_distance(matches.truths, 0.3) == {"0-0.7 m": (1.0, 1), "2.5-3.5 m": (0.0, 1)}


def test_a_frame_survives_its_line_of_json() -> None:
    one = frame(box("teddy bear", (1, 2, 30, 40)))
    assert from_json(to_json(one)) == one


def test_a_yolo_line_has_the_coco_number_and_the_centre() -> None:
    assert yolo_lines((box("bottle", (0, 0, 125, 250)),)) == "39 0.25000 0.50000 0.50000 1.00000\n"
