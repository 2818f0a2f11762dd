"""Where to draw the line: a CLIP threshold measured on crops the model never saw, and how right it is there."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass

import numpy as np
import numpy.typing as npt

from sim.training.phrases import Meaning, compared

Floats = npt.NDArray[np.float32]


@dataclass(frozen=True)
class Calibration:
    """The measured threshold and the shares that go with it."""

    threshold: float
    accepted_right: float
    """Share of crops accepted for their own phrase."""
    accepted_other_colour: float
    """Share of (crop, phrase) pairs accepted although the colour is another one."""
    accepted_other_kind: float
    """Share of (crop, phrase) pairs accepted although the kind is another one."""
    colour_accuracy: float
    """Share of coloured crops whose own colour scores best among the colours of their kind."""
    kind_accuracy: float
    """Share of crops whose own kind scores best among the kinds."""
    crops: int

    def as_dict(self) -> dict[str, float]:
        """The fields, rounded, for a JSON file."""
        return {name: round(value, 4) for name, value in asdict(self).items()}


def calibrate(
    embedded: Floats, meanings: Sequence[Meaning], embed_text: Callable[[Sequence[str]], Floats]
) -> Calibration:
    """Choose the threshold that best parts right pairs from wrong ones, half of the wrong being near misses.

    `embedded` is (n, d), unit vectors; `meanings` says what each crop shows. Phrases are the plain ones ("red
    bottle"). The measure is Youden's: share of right pairs accepted minus share of wrong pairs accepted.
    """
    phrases = sorted({*meanings, *compared(meanings)})
    bare = sorted({Meaning(one.kind) for one in meanings})
    cosine = embedded @ embed_text([one.plain for one in phrases]).T
    kinds, colours = np.array([one.kind for one in phrases]), np.array([one.colour for one in phrases])
    own_kind, own_colour = np.array([one.kind for one in meanings]), np.array([one.colour for one in meanings])
    same_kind, same_colour = own_kind[:, None] == kinds[None], own_colour[:, None] == colours[None]
    right = cosine[same_kind & same_colour]
    other_colour, other_kind = cosine[same_kind & ~same_colour], cosine[~same_kind]

    def gain(at: float) -> float:
        wrong = 0.5 * _share(other_colour >= at) + 0.5 * _share(other_kind >= at)
        return _share(right >= at) - wrong

    threshold = max(np.arange(0.0, 1.0, 0.01).tolist(), key=gain)
    coloured = own_colour != ""
    within = np.where(same_kind, cosine, -2.0).argmax(axis=1)
    to_kinds = embedded @ embed_text([one.plain for one in bare]).T
    named = np.array([one.kind for one in bare])[to_kinds.argmax(axis=1)]
    return Calibration(
        threshold=float(threshold),
        accepted_right=_share(right >= threshold),
        accepted_other_colour=_share(other_colour >= threshold),
        accepted_other_kind=_share(other_kind >= threshold),
        colour_accuracy=_share((colours[within] == own_colour)[coloured]),
        kind_accuracy=_share(named == own_kind),
        crops=len(meanings),
    )


def _share(hits: npt.NDArray[np.bool_]) -> float:
    return float(hits.mean()) if hits.size else 0.0
