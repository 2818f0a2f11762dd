"""Kills a writing memory with SIGKILL again and again: what it acknowledged must be there, and the file must open.

Writes out/bench/memory_kills.json.
"""

import argparse
import asyncio
import json
import random
import sqlite3
import subprocess
import sys
import tempfile
import threading
from contextlib import aclosing, closing
from pathlib import Path

from bench.results import save
from memory.adapters.store import SqlStore
from memory.settings import Settings

WRITER = """
import asyncio, sys
from contracts.geometry import Point3D, Pose2D
from contracts.memory import Observation
from memory.adapters.store import SqlStore
from memory.frames import frames_of
from memory.settings import Settings

async def main():
    store = SqlStore.from_settings(Settings(database_url="sqlite:///" + sys.argv[1]))
    for k in range(int(sys.argv[2]), 10_000_000):
        pose = Pose2D(x=k % 4000 * 0.25 + 0.1, y=k // 4000 * 0.25 + 0.1, yaw=0.1)
        seen = [Observation(label="cup", confidence=0.5, pose=pose, stamp_s=float(k))]
        if k % 50 == 0:  # now and then a thing with a place: two tables in one transaction
            place = Point3D(x=pose.x + 1.0, y=pose.y, z=0.5)
            seen.append(Observation(label="vase", confidence=0.5, pose=pose, stamp_s=float(k), position=place))
        await store.remember(frames_of(seen))
        print(k, flush=True)  # noqa: T201

asyncio.run(main())
"""


def killed_while_writing(path: Path, first: int, acknowledgements: int, delay_s: float) -> list[int]:
    """What the writer said was stored before it died, `delay_s` after its so-manieth word."""
    command = [sys.executable, "-c", WRITER, str(path), str(first)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as writer:
        assert writer.stdout is not None
        said = [int(writer.stdout.readline()) for _ in range(acknowledgements)]
        killer = threading.Timer(delay_s, writer.kill)
        killer.start()
        said += [int(line) for line in writer.stdout.read().splitlines()]
        killer.join()
        return said


async def kept(path: Path) -> set[int]:
    """Opens the store as the service does, then reads which observations are there."""
    async with aclosing(SqlStore.from_settings(Settings(database_url=f"sqlite:///{path}"))) as store:
        await store.check()
    with closing(sqlite3.connect(path)) as connection:
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        assert connection.execute("PRAGMA foreign_key_check").fetchall() == []
        return {int(row[0]) for row in connection.execute("SELECT last_seen_s FROM views WHERE label = 'cup'")}


def campaign(kills: int, seed: int, folder: Path) -> dict[str, int]:
    rng = random.Random(seed)
    path = folder / "memory.db"
    acknowledged: set[int] = set()
    for number in range(1, kills + 1):
        first = max(acknowledged, default=-1) + 2
        acknowledged |= set(killed_while_writing(path, first, rng.randint(1, 20), rng.uniform(0.0, 0.02)))
        there = asyncio.run(kept(path))
        lost = acknowledged - there
        aside = [file.name for file in folder.iterdir() if "corrupt" in file.name]
        assert not lost, f"kill {number}: {len(lost)} acknowledged observations are gone: {sorted(lost)[:5]}"
        assert not aside, f"kill {number}: the file was set aside as corrupt"
        if number % 20 == 0:
            print(f"{number} kills, {len(acknowledged)} acknowledged, {len(there)} kept, none lost", flush=True)  # noqa: T201
    return {"kills": kills, "acknowledged": len(acknowledged), "lost": 0, "files_set_aside": 0, "opened": kills}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("out/bench"))
    parser.add_argument("--quick", action="store_true", help="10 kills")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        found = campaign(10 if arguments.quick else arguments.kills, arguments.seed, Path(folder))
    save(arguments.out / "memory_kills.json", found)
    print(json.dumps(found))  # noqa: T201


if __name__ == "__main__":
    main()
