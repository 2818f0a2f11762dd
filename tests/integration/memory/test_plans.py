"""How SQLite finds what is asked for often: by an index that leads there, not through all that a year has left."""

import sqlite3
from collections.abc import Iterator
from contextlib import aclosing, closing
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import Engine, event

from contracts.geometry import Pose2D
from memory.frames import Frame, frames_of
from support.memory_database import opened
from support.observations import seen

Said = list[tuple[str, Any]]


@pytest.fixture
def said() -> Iterator[Said]:
    """Every SELECT sent to a database, with its parameters."""
    statements: Said = []

    def note(_connection: Any, _cursor: Any, statement: str, parameters: Any, _context: Any, _many: bool) -> None:
        if statement.startswith("SELECT"):
            statements.append((statement, parameters))

    event.listen(Engine, "before_cursor_execute", note)
    yield statements
    event.remove(Engine, "before_cursor_execute", note)


def plan(path: Path, statement: str, parameters: Any) -> str:
    with closing(sqlite3.connect(path)) as connection:
        rows = connection.execute(f"EXPLAIN QUERY PLAN {statement}", parameters).fetchall()
    return "; ".join(row[3] for row in rows)


async def test_a_look_reads_only_the_views_taken_round_about(tmp_path: Path, said: Said) -> None:
    path = tmp_path / "memory.db"
    async with aclosing(opened(path)) as store:
        await store.remember(frames_of([seen()]))
        said.clear()
        await store.remember([Frame(Pose2D(x=0.0, y=0.0, yaw=0.0), 5.0, is_look=True)])
        plans = [plan(path, *one) for one in said if "FROM views" in one[0] and "count(" not in one[0]]
    assert len(plans) == 1
    assert "USING INDEX views_place (map_number=? AND cell_x=? AND cell_y>? AND cell_y<?)" in plans[0]


async def test_recall_reads_nothing_from_end_to_end(tmp_path: Path, said: Said) -> None:
    path = tmp_path / "memory.db"
    async with aclosing(opened(path)) as store:
        await store.remember(frames_of([seen(), seen("cup", at=(1.0, 1.0))]))
        said.clear()
        await store.candidates({"cup": ("red",), "bottle": ()}, views_a_thing=4, views_max=1)
        plans = [plan(path, *one) for one in said]
    assert len(plans) >= 4
    assert not [one for one in plans if "SCAN" in one]
