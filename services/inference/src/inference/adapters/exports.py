"""Exports of a detector's weights: made on first use, timed, kept; says which to load.

    python -m inference.adapters.exports WEIGHTS.pt FOLDER --imgsz 320 --threads 1 --formats openvino,onnx

runs apart, because converting takes hundreds of megabytes and libraries that serving does not need.
"""

import argparse
import asyncio
import hashlib
import importlib.metadata
import importlib.util
import json
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from inference.adapters.yolo import OPENVINO_FOLDER, QUIET_AND_OFFLINE, YoloDetector, backend_of
from inference.settings import Backend

LIBRARIES = {Backend.OPENVINO: ("openvino",), Backend.ONNX: ("onnx", "onnxruntime")}
"""What each export needs to be made and run."""
FILES = {Backend.OPENVINO: f"detector{OPENVINO_FOLDER}", Backend.ONNX: "detector.onnx"}
TIMINGS = "timings.json"
WARM_UPS, TIMED = 3, 15
NICE = 5
"""Exporting yields to everything else on the machine."""


@dataclass(frozen=True, slots=True)
class Choice:
    """Which file the detector is loaded from, and what is known about the others."""

    path: Path
    backends_ms: dict[str, float] = field(default_factory=dict[str, float])
    """Fastest of a few calls of each backend that was tried; empty where there was nothing to choose."""


@dataclass(frozen=True)
class Exports:
    """What the weights can run on. Only a `.pt` file can be exported; an export runs on what it was made for."""

    weights: Path
    backend: Backend
    imgsz: int
    threads: int
    kept_in: Path
    timeout_s: float

    def check(self) -> None:
        """Raises FileNotFoundError without weights, ValueError for an export that is asked to be something else."""
        if not self.weights.exists():
            raise FileNotFoundError(f"no detector weights at {self.weights}")
        own = backend_of(self.weights)
        if own != Backend.TORCH and self.backend not in {Backend.AUTO, own}:
            raise ValueError(f"{self.weights} is an export for {own}; it cannot run on {self.backend}")

    def choice(self) -> Choice:
        """The wanted export, or for `auto` the fastest, where they were made and timed before; else the weights."""
        timings = _timings(self._folder(), self._wanted(), self.threads) if self._wanted() else None
        if timings is None:
            return Choice(self.weights)
        fastest = (
            Backend(min(timings, key=lambda name: timings[name])) if self.backend is Backend.AUTO else self.backend
        )
        return Choice(self.weights if fastest is Backend.TORCH else self._folder() / FILES[fastest], timings)

    def missing(self) -> bool:
        """There is something to make, or to time."""
        return bool(self._wanted()) and _timings(self._folder(), self._wanted(), self.threads) is None

    def trouble(self) -> str:
        """Why the backend asked for cannot be had, if it cannot."""
        if self.backend in {Backend.AUTO, Backend.TORCH, backend_of(self.weights)} or installed(self.backend):
            return ""
        return f"{self.backend} needs the package {' and '.join(LIBRARIES[self.backend])}"

    async def make(self) -> str:
        """Makes and times what is missing, in a process of its own and behind everything else; its trouble, or ''."""
        command = [sys.executable, "-m", __name__, str(self.weights), str(self._folder())]
        command += ["--imgsz", str(self.imgsz), "--threads", str(self.threads), "--formats", ",".join(self._wanted())]
        process = await asyncio.create_subprocess_exec(
            *command,
            env=os.environ | QUIET_AND_OFFLINE | {"OMP_NUM_THREADS": str(self.threads)},
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.DEVNULL,
            stderr=asyncio.subprocess.PIPE,
        )
        try:
            async with asyncio.timeout(self.timeout_s):
                _, said = await process.communicate()
        except TimeoutError:
            return f"it took longer than {self.timeout_s:g} s"
        finally:
            if process.returncode is None:
                process.kill()
                await process.wait()
        lines = said.decode(errors="replace").strip().splitlines() or [f"it ended with {process.returncode}"]
        return "" if process.returncode == 0 else lines[-1][:300]

    def _wanted(self) -> list[Backend]:
        if backend_of(self.weights) != Backend.TORCH:
            return []
        return [one for one in FILES if self.backend in {Backend.AUTO, one} and installed(one)]

    def _folder(self) -> Path:
        version = importlib.metadata.version("ultralytics-opencv-headless")
        digest = hashlib.sha256(self.weights.read_bytes() + version.encode()).hexdigest()[:12]
        return self.kept_in / f"{self.weights.stem}-{digest}-{self.imgsz}"


def installed(backend: Backend) -> bool:
    return all(importlib.util.find_spec(library) is not None for library in LIBRARIES[backend])


def _circumstances(threads: int) -> dict[str, Any]:
    """Timings hold for these alone."""
    libraries = ["torch", *(library for one in FILES if installed(one) for library in LIBRARIES[one])]
    versions = {library: importlib.metadata.version(library) for library in sorted(libraries)}
    return {"threads": threads, "cores": os.cpu_count(), "versions": versions}


def _timings(folder: Path, wanted: Sequence[Backend], threads: int) -> dict[str, float] | None:
    """Milliseconds a backend; none when an export or its timing is missing, or was made elsewhere."""
    try:
        kept = json.loads((folder / TIMINGS).read_text())
        timings = {str(name): float(value) for name, value in kept["ms"].items()}
        same = kept["circumstances"] == _circumstances(threads)
    except (OSError, ValueError, LookupError, TypeError, AttributeError):
        return None
    there = all((folder / FILES[one]).exists() and one in timings for one in wanted)
    return timings if there and same else None


def prepare(weights: Path, folder: Path, wanted: Sequence[Backend], *, imgsz: int, threads: int) -> dict[str, float]:
    """Makes the exports that are missing in `folder`, times torch and each of them, and writes the timings down."""
    folder.mkdir(parents=True, exist_ok=True)
    for one in wanted:
        if not (folder / FILES[one]).exists():
            _export(weights, folder, one, imgsz)
    candidates = {str(Backend.TORCH): weights} | {str(one): folder / FILES[one] for one in wanted}
    timings = (_timings(folder, [], threads) or {}) | {
        name: _fastest_ms(path, imgsz, threads) for name, path in candidates.items()
    }
    kept = {"circumstances": _circumstances(threads), "ms": timings}
    partial = folder / f"{TIMINGS}.{os.getpid()}"
    partial.write_text(json.dumps(kept, indent=1) + "\n")
    partial.replace(folder / TIMINGS)
    return timings


def _export(weights: Path, folder: Path, backend: Backend, imgsz: int) -> None:
    """Moved into place whole; where another process was quicker, its export stays."""
    from inference.perception import torchvision_cpu

    torchvision_cpu.install()
    from ultralytics import YOLO

    with tempfile.TemporaryDirectory(dir=folder) as scratch:
        copy = Path(scratch) / "detector.pt"
        shutil.copyfile(weights, copy)
        model: Any = YOLO(str(copy), task="detect")
        model.export(format=str(backend), imgsz=imgsz, device="cpu", verbose=False)
        made, place = Path(scratch) / FILES[backend], folder / FILES[backend]
        if not place.exists():
            made.rename(place)


def _fastest_ms(path: Path, imgsz: int, threads: int) -> float:
    """The quickest of a few calls: what neighbours on the machine do to the others says nothing about the backend."""
    detector = YoloDetector(path, threshold=0.30, imgsz=imgsz, threads=threads)
    image = np.random.default_rng(0).integers(0, 256, (imgsz, imgsz, 3), np.uint8)
    took_s: list[float] = []
    for _ in range(WARM_UPS + TIMED):
        began_s = time.perf_counter()
        detector.detect(image)
        took_s.append(time.perf_counter() - began_s)
    return round(min(took_s[WARM_UPS:]) * 1000, 2)


def main() -> None:
    parser = argparse.ArgumentParser(prog="inference.adapters.exports", description="Export and time a detector.")
    parser.add_argument("weights", type=Path, help="a .pt file of ultralytics")
    parser.add_argument("folder", type=Path, help="where the exports are kept")
    parser.add_argument("--imgsz", type=int, default=320, help="px, side of the square it looks at (default 320)")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--formats", default=",".join(FILES), help="openvino, onnx or both, with a comma")
    arguments = parser.parse_args()
    os.environ.update(QUIET_AND_OFFLINE)
    os.nice(NICE)
    wanted = [Backend(name) for name in arguments.formats.split(",")]
    prepare(arguments.weights, arguments.folder, wanted, imgsz=arguments.imgsz, threads=arguments.threads)


if __name__ == "__main__":
    main()
