"""What keeps the robot from the target, in a word a person knows: the furniture it stands on or behind."""

from contracts.vision import Detections

FURNITURE = frozenset({
    "bed", "bench", "chair", "couch", "dining table", "oven", "potted plant", "refrigerator", "sink", "suitcase",
    "toilet", "tv",
})  # fmt: skip


def furniture_before(seen: Detections, target: tuple[float, float, float, float]) -> str:
    """The label of the largest piece of furniture in the target's column that reaches lower in the picture than the
    target does, so stands nearer or carries it; empty when none is seen.
    """
    middle_u, target_low = (target[0] + target[2]) / 2, target[3]
    before = [
        d
        for d in seen.detections
        if d.label in FURNITURE
        and d.bbox_xyxy != target
        and d.bbox_xyxy[0] <= middle_u <= d.bbox_xyxy[2]
        and d.bbox_xyxy[3] >= target_low
    ]
    if not before:
        return ""
    return max(before, key=lambda d: (d.bbox_xyxy[2] - d.bbox_xyxy[0]) * (d.bbox_xyxy[3] - d.bbox_xyxy[1])).label


def hindrance(blocked: bool, furniture: str) -> str:
    """Why it came no nearer, in words; `blocked` when something ended its drive."""
    if furniture:
        return f"the {furniture.removeprefix('dining ')} is in the way"
    return "something is in the way" if blocked else "no nearer place can be reached"
