"""A service whose threads are all at work."""

from collections.abc import Iterator
from contextlib import contextmanager

import anyio.to_thread


@contextmanager
def every_worker_busy() -> Iterator[None]:
    """Whatever wants one of the threads that plain functions are sent to waits until the block ends."""
    threads = anyio.to_thread.current_default_thread_limiter()
    tokens = [object() for _ in range(int(threads.total_tokens))]
    for token in tokens:
        threads.acquire_on_behalf_of_nowait(token)
    try:
        yield
    finally:
        for token in tokens:
            threads.release_on_behalf_of(token)
