"""`python -m inference` as its supervisor runs it: up, seeing, streaming, and gone when told."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import httpx

from inference.adapters.yolo import DetectorCard
from inference.settings import Settings
from support.redis_server import free_port

from .bridge import running_bridge

READY_S_MAX = 60.0


def test_the_process_sees_streams_and_ends_when_told(
    redis_url: str, untrained_detector: Path, untrained_clip: Path
) -> None:
    port = free_port()
    with running_bridge() as bridge_url:
        environment = os.environ | {
            "INFERENCE_PORT": str(port),
            "INFERENCE_REDIS_URL": redis_url,
            "INFERENCE_ROBOT_BRIDGE_URL": bridge_url,
            "INFERENCE_DETECTOR_PATH": str(untrained_detector),
            "INFERENCE_CLIP_PATH": str(untrained_clip),
            "INFERENCE_DETECTOR_BACKEND": "torch",
        }
        process = subprocess.Popen([sys.executable, "-m", "inference"], env=environment)
        try:
            with httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=60.0, trust_env=False) as client:
                until_ready(client, process)
                with client.stream("GET", "/annotated/stream") as stream:
                    first = next(stream.iter_raw())
                    assert stream.headers["x-accel-buffering"] == "no"
                assert client.post("/detect").json()["image_width_px"] == 250
            process.send_signal(signal.SIGTERM)
            assert process.wait(timeout=60.0) == 0
        finally:
            process.kill()
            process.wait(timeout=60.0)
    assert first.startswith(b"--frame\r\nContent-Type: image/jpeg\r\n")
    assert b"\xff\xd8" in first


def until_ready(client: httpx.Client, process: "subprocess.Popen[bytes]") -> None:
    deadline_s = time.monotonic() + READY_S_MAX
    while time.monotonic() < deadline_s:
        assert process.poll() is None, "the service ended by itself"
        try:
            if client.get("/ready").status_code == 200:
                return
        except httpx.TransportError:
            pass
        time.sleep(0.1)
    raise AssertionError(f"not ready within {READY_S_MAX} s")


def test_importing_the_service_loads_no_model_library() -> None:
    heavy = "{'torch', 'ultralytics', 'ollama'}"
    code = f"import sys, inference.app, inference.__main__; sys.exit(bool({heavy} & {{*sys.modules}}))"
    assert subprocess.run([sys.executable, "-c", code], check=False, timeout=90).returncode == 0


def test_defaults_are_those_of_the_requirements() -> None:
    settings = Settings()
    assert (settings.port, settings.detector_confidence_min, settings.rest_rate_hz) == (8002, None, 2.0)
    assert DetectorCard().threshold == 0.30
    assert (settings.jpeg_quality, settings.spotted_period_s, settings.frame_width_px) == (60, 0.5, 0)
