"""Counting honestly: a share with its 95 % interval, percentiles of times."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

Z_95 = 1.96


def share(hits: int, of: int) -> dict[str, Any]:
    """Hits, out of how many, their share, and its Wilson interval."""
    low, high = wilson(hits, of)
    return {"n": hits, "of": of, "share": round(hits / of, 4) if of else None, "wilson_95": [low, high]}


def wilson(hits: int, of: int) -> tuple[float, float]:
    """E. B. Wilson, 1927: the interval of a proportion, good for small counts too."""
    if of == 0:
        return 0.0, 1.0
    p, z2 = hits / of, Z_95**2
    middle = (p + z2 / (2 * of)) / (1 + z2 / of)
    half = Z_95 * math.sqrt(p * (1 - p) / of + z2 / (4 * of**2)) / (1 + z2 / of)
    return round(max(0.0, middle - half), 4), round(min(1.0, middle + half), 4)


def percentiles(values_ms: Sequence[float]) -> dict[str, float]:
    return {
        "p50": round(float(np.percentile(values_ms, 50)), 2),
        "p99": round(float(np.percentile(values_ms, 99)), 2),
        "min": round(min(values_ms), 2),
    }
