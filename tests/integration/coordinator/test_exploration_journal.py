"""What explorations know of a home is on disk, and is there again after a restart."""

import asyncio
import sqlite3
from pathlib import Path

import pytest

from contracts.exploration import DecisionVerdict, Discovery, DoneAction, ExplorationMemory, ExplorationMode
from coordinator.adapters.exploration_journal import ExplorationJournal
from mesh.errors import UnavailableError

CUP = Discovery(label="cup", note="red", x_m=1.0, y_m=2.0, stamp_s=3.0)
DROVE = DoneAction(tool="move_toward", verdict=DecisionVerdict.SLOWED, end="completed", by=ExplorationMode.MODEL)
MEMORY = ExplorationMemory(discoveries=(CUP,), actions=(DROVE,), actions_done=1)


def journal(file: Path) -> ExplorationJournal:
    return ExplorationJournal(file, busy_timeout_s=0.2)


async def test_it_survives_a_restart_and_each_home_has_its_own(tmp_path: Path) -> None:
    first = journal(tmp_path / "exploration.db")
    first.write("flat", MEMORY)
    await first.aclose()
    second = journal(tmp_path / "exploration.db")
    assert await second.read("flat") == MEMORY
    assert await second.read("garden house") == ExplorationMemory()
    await second.aclose()


async def test_the_newest_counts_and_is_read_before_it_is_written(tmp_path: Path) -> None:
    one = journal(tmp_path / "exploration.db")
    one.write("flat", ExplorationMemory())
    one.write("flat", MEMORY)
    assert await one.read("flat") == MEMORY
    await one.flush()
    assert await one.read("flat") == MEMORY
    await one.aclose()


async def test_it_writes_by_itself(tmp_path: Path) -> None:
    one = journal(tmp_path / "exploration.db")
    await one.read("flat")
    writing = asyncio.create_task(one.write_forever())
    one.write("flat", MEMORY)

    def written() -> int:
        with sqlite3.connect(tmp_path / "exploration.db") as connection:
            return connection.execute("SELECT count(*) FROM explorations").fetchone()[0]

    async with asyncio.timeout(10.0):
        while await asyncio.to_thread(written) == 0:
            await asyncio.to_thread(writing.done)
    writing.cancel()
    await asyncio.gather(writing, return_exceptions=True)
    await one.aclose()


async def test_a_record_that_is_not_understood_begins_anew(tmp_path: Path) -> None:
    file = tmp_path / "exploration.db"
    one = journal(file)
    one.write("flat", MEMORY)
    await one.aclose()
    with sqlite3.connect(file) as connection:
        connection.execute('UPDATE explorations SET memory = \'{"of": "tomorrow"}\'')
    connection.close()
    again = journal(file)
    assert await again.read("flat") == ExplorationMemory()
    await again.aclose()


async def test_what_could_not_be_written_is_kept_until_it_can(tmp_path: Path) -> None:
    file = tmp_path / "exploration.db"
    one = journal(file)
    await one.read("flat")
    other = sqlite3.connect(file, isolation_level=None)
    other.execute("BEGIN EXCLUSIVE")
    one.write("flat", MEMORY)
    with pytest.raises(UnavailableError):
        await one.flush()
    other.rollback()
    other.close()
    await one.flush()
    assert await one.read("flat") == MEMORY
    await one.aclose()
