"""What several measurements of one thing come to: one alone may lie (a reflection, the wall behind)."""

from contracts.robot import LocalizeReply


def sigma_m(distance_m: float) -> float:
    """Of the stereo depth: fits the two published points (1.2 cm at 1.0 m, 28.6 cm at 2.5 m)."""
    return 0.012 * distance_m**3.461


def alike(a_m: float, b_m: float) -> bool:
    """Whether two measurements can be of the same thing: within three sigma of the nearer one, at least 12 cm."""
    return abs(a_m - b_m) <= 0.12 + 3.0 * min(sigma_m(min(a_m, b_m)), 0.3)


def agreed(samples: tuple[LocalizeReply, ...]) -> tuple[LocalizeReply | None, int]:
    """The middle one of the largest group of samples that are alike (of equal groups the farther), and its size."""
    measured = sorted((s for s in samples if s.distance_m is not None), key=_distance_m)
    groups = [[other for other in measured if alike(_distance_m(one), _distance_m(other))] for one in measured]
    if not groups:
        return None, 0
    group = max(groups, key=lambda g: (len(g), _distance_m(g[0])))
    return group[(len(group) - 1) // 2], len(group)


def _distance_m(sample: LocalizeReply) -> float:
    return sample.distance_m if sample.distance_m is not None else 0.0
