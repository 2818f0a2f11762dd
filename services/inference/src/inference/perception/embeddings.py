"""An image-text model's numbers, looked at before they decide: rows asked for, and unit vectors of one size."""

from collections.abc import Callable

import numpy as np

from inference.ports import MODEL_ERRORS, Embeddings
from mesh.errors import UnavailableError

OVER_ONE_MAX = 0.02
"""What rounding adds to a length, in bf16 too."""


class NoEmbeddingError(UnavailableError):
    """The image-text model failed, or its numbers are none."""

    def __init__(self, detail: str) -> None:
        super().__init__("clip", detail)


def embedded(embed: Callable[[], Embeddings], rows: int) -> Embeddings:
    """(rows, d); whether each is a unit vector is for `unit` to say. Raises `NoEmbeddingError`."""
    try:
        found = embed()
    except MODEL_ERRORS as error:
        raise NoEmbeddingError(f"it failed: {error}") from error
    if found.ndim != 2 or found.shape[0] != rows:
        raise NoEmbeddingError(f"embeddings of the shape {found.shape} for {rows} asked for")
    return found


def unit(embeddings: Embeddings) -> Embeddings:
    """The same. Raises `NoEmbeddingError` where a row is no unit vector, finite and of length 1."""
    with np.errstate(all="ignore"):
        lengths = np.linalg.norm(embeddings, axis=1)
    if not (np.abs(lengths - 1.0) <= OVER_ONE_MAX).all():
        raise NoEmbeddingError("its embeddings are no unit vectors")
    return embeddings


def cosines(images: Embeddings, texts: Embeddings) -> Embeddings:
    """(n images, m texts), each -1..1. Raises `NoEmbeddingError`."""
    if images.shape[1] != texts.shape[1]:
        raise NoEmbeddingError(f"embeddings of the shapes {images.shape} and {texts.shape}")
    return unit(images) @ unit(texts).T
