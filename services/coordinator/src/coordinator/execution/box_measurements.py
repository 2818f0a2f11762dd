"""How far away and where the boxes of the newest pictures are, as inference published it with them."""

from collections import deque

from contracts.measuring import Measurement
from contracts.robot import BoxQuery
from contracts.vision import Detections
from mesh.errors import UnavailableError

PICTURES_MAX = 30
"""Six seconds at 5 Hz: an older box is looked at again before it is measured."""


class BoxMeasurements:
    """Nobody is asked: a picture's boxes are measured once, for all who need it."""

    def __init__(self) -> None:
        self._pictures: deque[Detections] = deque(maxlen=PICTURES_MAX)

    def take(self, seen: Detections) -> None:
        self._pictures.append(seen)

    def of(self, box: BoxQuery) -> Measurement:
        """Raises `UnavailableError` where robot_bridge did not measure it."""
        found = (
            one.measurement
            for seen in reversed(self._pictures)
            if seen.stamp_s == box.stamp_s
            for one in seen.detections
            if one.bbox_xyxy == box.bbox_xyxy
        )
        measurement = next(found, None)
        if measurement is None or not measurement.answered:
            raise UnavailableError(
                "robot_bridge", measurement.text if measurement is not None else "nobody measured it"
            )
        return measurement
