"""The folder of finished wheels: an entry is there whole or not at all."""

import fcntl
import os
import shutil
import tempfile
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path

WORK_PREFIX = ".build-"


def cache_root() -> Path:
    """`$ATOM_CACHE_DIR/interfaces`, else `$XDG_CACHE_HOME/atom/interfaces`, else `~/.cache/atom/interfaces`."""
    own = os.environ.get("ATOM_CACHE_DIR")
    if own:
        return Path(own).expanduser().resolve() / "interfaces"
    user = os.environ.get("XDG_CACHE_HOME")
    return (Path(user) if user else Path.home() / ".cache") / "atom" / "interfaces"


def cached_wheels(root: Path, key: str) -> tuple[Path, ...]:
    """The wheels under `key`, or an empty tuple."""
    return tuple(sorted((root / key).glob("*.whl")))


def fill(root: Path, key: str, build: Callable[[Path], Path]) -> tuple[Path, ...]:
    """The wheels under `key`, made by `build` where nobody has made them yet.

    `build` gets an empty working folder and returns the folder in it that holds the wheels; that one is moved into
    place in one step, the rest is removed. A second process waits here for the first and then finds its wheels; what a
    killed one left behind goes with a later build.
    """
    root.mkdir(parents=True, exist_ok=True)
    with _only_one(root / ".lock"):
        if not cached_wheels(root, key):
            for leftover in root.glob(f"{WORK_PREFIX}*"):
                shutil.rmtree(leftover, ignore_errors=True)  # a killed build's children may still write to it
            with tempfile.TemporaryDirectory(prefix=WORK_PREFIX, dir=root) as work_dir:
                build(Path(work_dir)).replace(root / key)
        return cached_wheels(root, key)


@contextmanager
def _only_one(path: Path) -> Generator[None, None, None]:
    with path.open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield
