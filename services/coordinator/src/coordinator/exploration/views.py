"""Whether the camera still shows the same: a perceptual hash of a picture.

64 bits of the signs of its low frequencies (pHash; Zauner, "Implementation and benchmarking of perceptual image hash
functions", 2010), which grain and light hardly change.
"""

from typing import Any, Final, cast

import numpy as np
from numpy.typing import NDArray
from scipy import fft  # pyright: ignore[reportMissingTypeStubs]

SIDE: Final = 32
BITS_SIDE: Final = 8
COLOUR_AXES: Final = 3


def view_hash(pixels: NDArray[np.uint8]) -> int:
    """64 bits of a picture (height, width) or (height, width, 3), at least `SIDE` pixels each side."""
    grey: NDArray[np.float64] = pixels.mean(axis=2) if pixels.ndim == COLOUR_AXES else pixels.astype(np.float64)
    height, width = pixels.shape[0], pixels.shape[1]
    rows, columns = (np.arange(SIDE) * size // SIDE for size in (height, width))
    means = np.add.reduceat(np.add.reduceat(grey, rows, axis=0), columns, axis=1)
    spectrum: NDArray[np.float64] = np.asarray(cast(Any, fft).dctn(means, norm="ortho"))
    low = spectrum[:BITS_SIDE, :BITS_SIDE].ravel()
    bits = low > np.median(low[1:])
    return int(sum(1 << index for index, bit in enumerate(bits.tolist()) if bit))


def bits_apart(one: int, other: int) -> int:
    return (one ^ other).bit_count()
