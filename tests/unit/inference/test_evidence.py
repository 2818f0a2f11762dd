"""Pictures of what was judged: the newest are kept, and none is large."""

import cv2
import numpy as np
import pytest

from inference.validation.evidence import KEPT, SIDE_PX_MAX, Evidence
from mesh.errors import NotFoundError


def test_the_newest_are_kept_and_the_oldest_forgotten() -> None:
    evidence = Evidence()
    names = [evidence.keep(np.zeros((4, 4, 3), np.uint8)) for _ in range(KEPT + 1)]
    assert len(set(names)) == KEPT + 1
    assert evidence.jpeg(names[1])
    with pytest.raises(NotFoundError):
        evidence.jpeg(names[0])


@pytest.mark.parametrize(("height", "width"), [(1, 1), (40, 20), (3000, 20), (2000, 4000)])
def test_it_is_as_it_was_shown_and_no_larger_than_a_page_needs(height: int, width: int) -> None:
    evidence = Evidence()
    jpeg = evidence.jpeg(evidence.keep(np.full((height, width, 3), (200, 10, 10), np.uint8)))
    shown = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
    assert shown is not None
    assert max(shown.shape[:2]) == min(SIDE_PX_MAX, max(height, width))
    assert shown[0, 0, 2] > 150 > shown[0, 0, 0]
