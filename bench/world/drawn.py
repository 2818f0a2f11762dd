"""Names and delays that services draw by chance, drawn from a seed instead."""

import contextlib
import random
import uuid
from collections.abc import Generator


@contextlib.contextmanager
def drawn_from(seed: int) -> Generator[None]:
    """While it lasts `uuid.uuid4` and `random` give the same for the same seed."""
    names, before, real = random.Random(seed), random.getstate(), uuid.uuid4
    random.seed(seed)
    uuid.uuid4 = lambda: uuid.UUID(int=names.getrandbits(128), version=4)
    try:
        yield
    finally:
        uuid.uuid4 = real
        random.setstate(before)
