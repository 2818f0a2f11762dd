"""Pictures of the moments a timeline tells of: the newest few hundred, in memory only."""

from collections import OrderedDict

from ui.frames import Shown


class EventPictures:
    """By mission and event; the oldest leave first."""

    def __init__(self, pictures_max: int) -> None:
        self._pictures_max = pictures_max
        self._pictures: OrderedDict[tuple[str, int], Shown] = OrderedDict()

    def put(self, mission_id: str, event_id: int, shown: Shown) -> None:
        self._pictures[mission_id, event_id] = shown
        while len(self._pictures) > self._pictures_max:
            self._pictures.popitem(last=False)

    def get(self, mission_id: str, event_id: int) -> Shown | None:
        return self._pictures.get((mission_id, event_id))

    def has(self, mission_id: str, event_id: int) -> bool:
        return (mission_id, event_id) in self._pictures
