"""The inference service with a Redis and a camera stand-in, each a process of its own, for as long as a block lasts."""

import contextlib
import socket
import subprocess
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import httpx
import psutil

from bench.processes import Processes
from contracts.problem import Readiness

START_S_MAX = 180.0


@dataclass(frozen=True)
class Running:
    port: int
    redis_url: str
    pid: int

    def rss_mb(self) -> float:
        return psutil.Process(self.pid).memory_info().rss / 1e6


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextlib.contextmanager
def running_service(pictures: Sequence[Path], *, camera_hz: float, settings: dict[str, str]) -> Iterator[Running]:
    """Yields once `/ready` says yes. Without pictures there is no camera, and the models alone are waited for."""
    redis_port, camera_port, port = free_port(), free_port(), free_port()
    environment = {
        "INFERENCE_PORT": str(port),
        "INFERENCE_REDIS_URL": f"redis://127.0.0.1:{redis_port}/0",
        "INFERENCE_ROBOT_BRIDGE_URL": f"http://127.0.0.1:{camera_port}",
        "OMP_NUM_THREADS": "1",
        **settings,
    }
    quiet = {"stdout": subprocess.DEVNULL}
    with Processes(environment) as processes:
        redis_url = processes.redis(redis_port)
        if pictures:
            camera = ("-m", "bench.seeing.camera", "--port", str(camera_port), "--rate-hz", str(camera_hz))
            processes.python(*camera, *(str(picture.resolve()) for picture in pictures), **quiet)
        service = processes.python("-m", "inference", **quiet)
        wait_until_ready(port, service, with_frames=bool(pictures))
        yield Running(port, redis_url, service.pid)


def wait_until_ready(port: int, service: "subprocess.Popen[bytes]", *, with_frames: bool) -> None:
    deadline_s = time.monotonic() + START_S_MAX
    told = "no answer"
    while time.monotonic() < deadline_s:
        if service.poll() is not None:
            raise SystemExit("the service ended by itself")
        with contextlib.suppress(httpx.TransportError):
            answer = httpx.get(f"http://127.0.0.1:{port}/ready", timeout=5.0, trust_env=False)
            told = answer.text
            models = Readiness.model_validate_json(answer.content).dependencies[0]
            if answer.is_success or (models.ok and not with_frames):
                return
        time.sleep(0.2)
    raise SystemExit(f"the service was not ready within {START_S_MAX:g} s: {told}")
