"""What several measurements of one thing come to: one alone may lie (a reflection, the wall behind)."""

from contracts.measuring import Measurement


def alike(one: Measurement, other: Measurement) -> bool:
    """Whether two measurements can be of the same thing: within three sigma of the nearer one, at least 12 cm."""
    nearer = min(one, other, key=_distance_m)
    return abs(_distance_m(one) - _distance_m(other)) <= 0.12 + 3.0 * min(nearer.sigma_m or 0.0, 0.3)


def agreed(samples: tuple[Measurement, ...]) -> tuple[Measurement | None, int]:
    """The middle one of the largest group of samples that are alike (of equal groups the farther), and its size."""
    measured = sorted((s for s in samples if s.distance_m is not None), key=_distance_m)
    groups = [[other for other in measured if alike(one, other)] for one in measured]
    if not groups:
        return None, 0
    group = max(groups, key=lambda g: (len(g), _distance_m(g[0])))
    return group[(len(group) - 1) // 2], len(group)


def _distance_m(sample: Measurement) -> float:
    return sample.distance_m if sample.distance_m is not None else 0.0
