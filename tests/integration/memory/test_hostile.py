"""What goes wrong on real machines: full disks, read-only folders, second writers, huge batches, clocks."""

import asyncio
import json
import os
import subprocess
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import httpx
import pytest
from asgi_lifespan import LifespanManager

from contracts.memory import DeletedReply, ObservationBatch, ObservationsReply, View
from memory.app import create_app
from memory.settings import Settings
from mesh.errors import UnavailableError
from mesh.http import ServiceClient
from support.described import described_bus
from support.fake_clock import FakeClock
from support.observations import seen
from support.waiting import until_true


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "memory.db"


@asynccontextmanager
async def serving(path: Path, **given: object) -> AsyncIterator[ServiceClient]:
    settings = Settings(database_url=f"sqlite:///{path}", robot_bridge_url="", busy_timeout_s=5.0)
    app = create_app(settings, bus=described_bus(), **given)  # type: ignore[arg-type]
    async with LifespanManager(app) as manager:
        client = ServiceClient("memory", "http://memory", transport=httpx.ASGITransport(manager.app), timeout_s=30.0)
        yield client
        await client.aclose()


async def told(client: ServiceClient, *xs: float, stamp_s: float = 1.0) -> ObservationsReply:
    batch = ObservationBatch(observations=tuple(seen(x=x, stamp_s=stamp_s) for x in xs))
    return await client.post("/observations", batch, ObservationsReply)


async def run_python(program: str, *arguments: str) -> str:
    """What it said; in a process of its own, for it changes what a process may do."""
    run = await asyncio.to_thread(
        subprocess.run,
        [sys.executable, "-c", program, *arguments],
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    return run.stdout


FULL = """
import asyncio, resource, signal, sys
from memory.frames import frames_of
from mesh.errors import UnavailableError
from support.memory_database import opened
from support.observations import seen
from pathlib import Path

async def main():
    store = opened(Path(sys.argv[1]))
    await store.remember(frames_of([seen(x=0.1)]))
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, resource.RLIM_INFINITY))
    kept = 1
    try:
        for k in range(1, 1000):
            await store.remember(frames_of([seen(x=k * 0.25 + 0.1, y=float(n)) for n in range(50)]))
            kept += 50
    except UnavailableError as error:
        print(kept, error.detail)
    print(len(await store.views(None, 100_000)))
    resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
    await store.remember(frames_of([seen("cup")]))
    print(len(await store.views(None, 100_000)))
    await store.aclose()

asyncio.run(main())
"""


async def test_a_full_disk_is_a_named_trouble_keeps_what_was_acknowledged_and_heals(path: Path) -> None:
    """A limit on the size of files stands in for the disk."""
    first, then, healed = (await run_python(FULL, str(path))).splitlines()
    acknowledged, trouble = first.split(" ", 1)
    assert "database" in trouble
    assert int(then) == int(acknowledged)
    assert int(healed) == int(acknowledged) + 1


READ_ONLY = """
import asyncio, os, sys, tempfile
from pathlib import Path
from memory.frames import frames_of
from mesh.errors import UnavailableError
from support.memory_database import opened
from support.observations import seen

async def main():
    folder = Path(tempfile.mkdtemp())
    store = opened(folder / "memory.db")
    await store.remember(frames_of([seen()]))
    await store.views(None, 10)  # who reads already goes on reading
    store._connections._writer.dispose()
    for one in (*folder.iterdir(), folder):
        one.chmod(0o444 if one.is_file() else 0o555)
    if os.geteuid() == 0:  # permissions do not bind root
        os.setuid(65534)
    try:
        await store.remember(frames_of([seen("cup")]))
    except UnavailableError as error:
        print(error.detail)
    print(len(await store.views(None, 10)))

asyncio.run(main())
"""


async def test_a_file_that_becomes_read_only_is_a_named_trouble_and_reading_goes_on() -> None:
    trouble, left = (await run_python(READ_ONLY)).splitlines()
    assert "readonly database" in trouble
    assert left == "1"


async def test_a_folder_in_which_nothing_can_be_made_is_a_503_at_the_first_write() -> None:
    async with serving(Path("/proc/memory.db")) as client:
        with pytest.raises(UnavailableError, match="database"):
            await told(client, 1.0)
        assert (await client.http.get("/ready")).status_code == 503


async def test_two_writers_of_one_file_lose_nothing_of_each_other(path: Path) -> None:
    async with serving(path) as one, serving(path) as other:
        for k in range(10):
            await asyncio.gather(told(one, float(k)), told(other, 100.0 + k))
        seen_by_one, seen_by_other = await one.get_list("/views", View), await other.get_list("/views", View)
    assert len(seen_by_one) == 20
    assert seen_by_one == seen_by_other


async def test_a_clock_that_goes_back_loses_nothing_and_makes_nothing_immortal(path: Path) -> None:
    clock = FakeClock(2000.0)
    async with serving(path, clock=clock) as client:
        await told(client, 1.0, stamp_s=1999.0)
    async with serving(path, clock=FakeClock(500.0)) as client:
        await told(client, 2.0, stamp_s=501.0)
        await told(client, 3.0, stamp_s=9e9)
        kept = {one.pose.x: one.stamp_s for one in await client.get_list("/views", View)}
        assert kept == {1.0: 1999.0, 2.0: 500.0, 3.0: 500.0}
        answer = await client.http.post("/recall", json={"target": {"label": "bottle", "description": "bottle"}})
        assert len(answer.json()["views"]) == 3


async def test_a_hundred_thousand_observations_at_once_are_refused_clearly(path: Path) -> None:
    async with serving(path) as client:
        one = seen().model_dump(mode="json")
        answer = await client.http.post("/observations", content=json.dumps({"observations": [one] * 100_000}))
        assert answer.status_code == 413
        assert "the limit is 1000000 bytes" in answer.json()["detail"]
        assert await client.get_list("/views", View) == []


@pytest.mark.parametrize("number", ["NaN", "Infinity", "-Infinity", "1e999"])
@pytest.mark.parametrize("field", ["x", "y", "yaw"])
async def test_a_pose_that_is_no_number_is_refused(path: Path, field: str, number: str) -> None:
    body = ObservationBatch(observations=(seen(),)).model_dump_json().replace(f'"{field}":0.0', f'"{field}":{number}')
    async with serving(path) as client:
        answer = await client.http.post("/observations", content=body, headers={"content-type": "application/json"})
        assert answer.status_code == 422
        assert await client.get_list("/views", View) == []


async def test_what_was_forgotten_is_not_in_the_files_any_more(path: Path) -> None:
    async with serving(path) as client:
        batch = ObservationBatch(
            observations=tuple(seen("zebrastripe", x=float(k), at=(k + 1.0, 0.0)) for k in range(99))
        )
        await client.post("/observations", batch, ObservationsReply)
        assert holds(path, b"zebrastripe")
        assert await client.delete("/labels/zebrastripe", DeletedReply) == DeletedReply(deleted=198)
        assert not holds(path, b"zebrastripe")


async def test_a_label_excluded_later_is_forgotten_at_the_next_start(path: Path) -> None:
    async with serving(path) as client:
        await client.post("/observations", ObservationBatch(observations=(seen("Cat"), seen())), ObservationsReply)
    settings = Settings(database_url=f"sqlite:///{path}", robot_bridge_url="", excluded_labels=("cat",))
    async with (
        LifespanManager(create_app(settings, bus=described_bus())) as manager,
        httpx.AsyncClient(transport=httpx.ASGITransport(manager.app), base_url="http://memory") as client,
    ):
        await until_true(lambda: only_bottles(client), timeout_s=30.0)


async def only_bottles(client: httpx.AsyncClient) -> bool:
    return [one["label"] for one in (await client.get("/labels")).json()] == ["bottle"]


def holds(path: Path, words: bytes) -> bool:
    return any(words in file.read_bytes() for file in path.parent.iterdir())
