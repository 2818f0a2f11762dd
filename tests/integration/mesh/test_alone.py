"""A service started long before all else: it says what it waits for, goes on when that comes, and ends with 0."""

import asyncio
import os
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import httpx
import pytest

from contracts.memory import ObservationBatch
from contracts.problem import Readiness
from support.observations import seen
from support.redis_server import free_port, start_redis
from support.waiting import until_true

DRAINED_S = 10.0
"""The grace that compose.yaml gives; five seconds are meant, which two cores under a load of 16 do not always keep."""
OTHERS = {
    "memory": set[str](),
    "coordinator": {"robot_bridge", "inference", "memory", "session", "robot.description", "robot.state"},
}
"""What each lacks besides Redis where nothing else runs: memory remembers views without the robot."""


@dataclass
class Started:
    name: str
    process: "subprocess.Popen[bytes]"
    http: httpx.AsyncClient
    redis_port: int

    async def lacks(self) -> set[str] | None:
        """None: it does not answer."""
        try:
            answer = await self.http.get("/ready")
        except httpx.TransportError:
            return None
        readiness = Readiness.model_validate_json(answer.content)
        assert answer.is_success == readiness.ready
        assert all(one.detail for one in readiness.dependencies if not one.ok)
        return {one.name for one in readiness.dependencies if not one.ok}

    async def until_it_lacks(self, what: set[str]) -> None:
        async def so() -> bool:
            return await self.lacks() == what

        await until_true(so)


@pytest.fixture(params=OTHERS)
def started(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Started]:
    name, port, redis_port = request.param, free_port(), free_port()
    nowhere = f"http://127.0.0.1:{free_port()}"
    prefix = name.upper()
    others = {"COORDINATOR_INFERENCE_URL": nowhere, "COORDINATOR_MEMORY_URL": nowhere} if name == "coordinator" else {}
    environment = {
        **os.environ,
        **others,
        f"{prefix}_PORT": str(port),
        f"{prefix}_REDIS_URL": f"redis://127.0.0.1:{redis_port}/0",
        f"{prefix}_ROBOT_BRIDGE_URL": nowhere,
        f"{prefix}_DATABASE_URL": f"sqlite:///{tmp_path}/{name}.db",
    }
    process = subprocess.Popen([sys.executable, "-m", name], env=environment, stdout=subprocess.DEVNULL)
    http = httpx.AsyncClient(base_url=f"http://127.0.0.1:{port}", trust_env=False, timeout=10.0)
    yield Started(name, process, http, redis_port)
    process.kill()
    process.wait()


async def test_a_service_alone_names_what_it_waits_for_and_goes_on_when_it_comes(
    started: Started, tmp_path: Path
) -> None:
    await started.until_it_lacks({"redis", *OTHERS[started.name]})
    redis = await asyncio.to_thread(start_redis, started.redis_port)
    try:
        await started.until_it_lacks(OTHERS[started.name])
        redis.terminate()
        await asyncio.to_thread(redis.wait, 45)
        await started.until_it_lacks({"redis", *OTHERS[started.name]})
    finally:
        redis.kill()
    if started.name == "memory":
        batch = ObservationBatch(observations=(seen(stamp_s=1.7e9),))
        assert (await started.http.post("/observations", json=batch.model_dump(mode="json"))).is_success
    begun_s = time.monotonic()
    started.process.send_signal(signal.SIGTERM)
    code = await asyncio.to_thread(started.process.wait, 30.0)
    took_s = time.monotonic() - begun_s
    assert code == 0
    assert took_s < DRAINED_S
    await started.http.aclose()
    with closing(sqlite3.connect(tmp_path / f"{started.name}.db")) as connection:
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        tables = {"memory": "views", "coordinator": "missions"}
        assert connection.execute(f"SELECT count(*) FROM {tables[started.name]}").fetchone() == (
            (1,) if started.name == "memory" else (0,)
        )
