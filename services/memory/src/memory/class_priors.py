"""What is known of classes of things beforehand (pure): how long they stay, their size, how far one sees them."""

from dataclasses import dataclass

DAY_S = 86_400.0


@dataclass(frozen=True, slots=True)
class ClassPrior:
    """`radius_m`: two sightings nearer than this may be one thing. `reach`: how many times farther than a cup a
    detector finds it."""

    half_life_s: float
    radius_m: float
    reach: float = 1.0


FIXED = ClassPrior(half_life_s=365.0 * DAY_S, radius_m=1.0, reach=2.0)
COUCH = ClassPrior(half_life_s=365.0 * DAY_S, radius_m=1.8, reach=2.0)
CHAIR = ClassPrior(half_life_s=7.0 * DAY_S, radius_m=0.6, reach=1.6)
SETTLED = ClassPrior(half_life_s=60.0 * DAY_S, radius_m=0.5, reach=1.3)
CARRIED = ClassPrior(half_life_s=2.0 * DAY_S, radius_m=0.4)
"""What people carry about: cups, bottles, telephones."""
ALIVE = ClassPrior(half_life_s=600.0, radius_m=0.6, reach=1.3)
ORDINARY = ClassPrior(half_life_s=7.0 * DAY_S, radius_m=0.45)

KINDS: dict[str, ClassPrior] = {
    **dict.fromkeys(("refrigerator", "oven", "toilet", "sink", "tv", "microwave", "toaster"), FIXED),
    **dict.fromkeys(("couch", "bed", "dining table"), COUCH),
    **dict.fromkeys(("chair", "bench"), CHAIR),
    **dict.fromkeys(("potted plant", "clock", "vase", "suitcase", "bicycle", "motorcycle"), SETTLED),
    **dict.fromkeys(
        ("cup", "bottle", "wine glass", "bowl", "fork", "knife", "spoon", "cell phone", "remote", "handbag", "backpack",
         "umbrella", "scissors", "toothbrush", "sports ball", "banana", "apple", "orange"), CARRIED),
    **dict.fromkeys(("cat", "dog", "bird"), ALIVE),
}  # fmt: skip


def kind_of(label: str) -> ClassPrior:
    return KINDS.get(label, ORDINARY)
