"""Back-up of a memory that is written to, and restore: the same again, or nothing changed."""

import asyncio
import sqlite3
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager, closing
from pathlib import Path

import httpx
import pytest
from asgi_lifespan import LifespanManager

from contracts.backup import SCHEMA_HEADER, BackupRefusal, RestoreReply
from contracts.memory import ObservationBatch
from memory.adapters.store import SqlStore
from memory.app import create_app
from memory.settings import Settings
from mesh import server
from store.copies import JudgedDatabase
from store.shared_lock import SharedLock
from support.described import described_bus
from support.observations import seen
from support.postgres_server import fresh_database
from support.served import served
from support.waiting import until

A_BATCH = 7
"""Views that one request writes in one transaction."""
NEWEST = "0005"


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "memory.db"


@asynccontextmanager
async def serving(url: str, **settings: object) -> AsyncIterator[httpx.AsyncClient]:
    app = create_app(
        Settings.model_validate({"database_url": url, "robot_bridge_url": "", **settings}), bus=described_bus()
    )
    async with LifespanManager(app) as manager:
        transport = httpx.ASGITransport(manager.app)
        async with httpx.AsyncClient(transport=transport, base_url="http://memory", timeout=60.0) as client:
            yield client


@pytest.fixture
async def client(path: Path) -> AsyncIterator[httpx.AsyncClient]:
    async with serving(f"sqlite:///{path}") as one:
        yield one


async def tell(client: httpx.AsyncClient, *xs: float, label: str = "bottle") -> None:
    batch = ObservationBatch(observations=tuple(seen(label, x=x, stamp_s=1.7e9, at=(x, 1.0)) for x in xs))
    answer = await client.post("/observations", json=batch.model_dump(mode="json"))
    assert answer.is_success, answer.text


async def told(client: httpx.AsyncClient) -> dict[str, object]:
    """Everything that can be asked for, but for how much time has passed since."""
    return {
        "export": (await client.get("/export")).text,
        "views": (await client.get("/views")).json(),
        "maps": (await client.get("/maps")).json(),
        "labels": (await client.get("/labels")).json(),
    }


async def restored(client: httpx.AsyncClient, database: bytes, **query: object) -> RestoreReply:
    answer = await client.post("/restore", content=database, params=query)
    assert answer.is_success, answer.text
    return RestoreReply.model_validate_json(answer.content)


def rows_of(database: bytes, place: Path, query: str = "SELECT count(*) FROM views") -> int:
    place.write_bytes(database)
    with closing(sqlite3.connect(place)) as connection:
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        return int(connection.execute(query).fetchone()[0])


async def test_a_back_up_made_while_it_is_written_to_holds_whole_transactions_only(
    client: httpx.AsyncClient, tmp_path: Path
) -> None:
    written = 0

    async def write_on() -> None:
        nonlocal written
        while True:
            await tell(client, *(0.5 * (A_BATCH * written + one) for one in range(A_BATCH)))
            written += 1

    writing = asyncio.create_task(write_on())
    counts: list[int] = []
    during: list[int] = []
    for number in range(6):
        await until(lambda known=written: written > known)
        before = written
        answer = await client.get("/backup")
        during.append(written - before)
        assert answer.headers[SCHEMA_HEADER] == NEWEST
        counts.append(rows_of(answer.content, tmp_path / f"{number}.db"))
    writing.cancel()
    await asyncio.gather(writing, return_exceptions=True)
    assert [one % A_BATCH for one in counts] == [0] * 6
    assert counts == sorted(counts)
    assert counts[0] < counts[-1]


async def test_a_restore_gives_exactly_what_was_backed_up(client: httpx.AsyncClient, path: Path) -> None:
    await tell(client, 1.0, 2.0, 3.0)
    before = await told(client)
    database = (await client.get("/backup")).content
    await tell(client, 9.0, label="cup")
    after = await told(client)
    checked = await restored(client, database, dry_run=True)
    assert (checked.applied, checked.kept_as, checked.rows["views"]) == (False, "", 3)
    assert await told(client) == after != before
    reply = await restored(client, database)
    assert await told(client) == before
    assert (reply.applied, reply.revision) == (True, NEWEST)
    assert rows_of(path.with_name(reply.kept_as).read_bytes(), path.with_name("kept.db")) == 4
    await tell(client, 5.0, label="book")
    assert (await client.get("/ready")).json()["dependencies"][0]["state"] == "ready"
    assert {one["label"] for one in (await client.get("/labels")).json()} == {"bottle", "book"}


async def test_what_is_restored_is_there_after_a_restart(path: Path) -> None:
    async with serving(f"sqlite:///{path}") as client:
        await tell(client, 1.0)
        database, before = (await client.get("/backup")).content, await told(client)
        await tell(client, 4.0)
        await restored(client, database)
    async with serving(f"sqlite:///{path}") as client:
        assert await told(client) == before


async def test_readers_and_writers_go_on_during_restores(client: httpx.AsyncClient, path: Path) -> None:
    await tell(client, *map(float, range(50)))
    database = (await client.get("/backup")).content
    answers: list[int] = []

    async def ask(path: str) -> None:
        while True:
            answers.append((await client.get(path)).status_code)

    async def write() -> None:
        while True:
            await tell(client, 500.0)

    busy = [asyncio.create_task(one) for one in (ask("/views"), ask("/labels"), ask("/objects"), write())]
    for _ in range(6):
        known = len(answers)
        await restored(client, database)
        await until(lambda known=known: len(answers) > known + 3)
    for one in busy:
        one.cancel()
    assert not [
        done for done in await asyncio.gather(*busy, return_exceptions=True) if isinstance(done, AssertionError)
    ]
    assert set(answers) == {200}
    kept = sorted(one.name for one in path.parent.glob("memory.db*") if "restore" in one.name)
    assert kept == [f"memory.db.before-restore-{number}" for number in (4, 5, 6)]


async def test_numbers_of_maps_are_those_of_the_restored_database(client: httpx.AsyncClient, tmp_path: Path) -> None:
    """The same home is map 0 here and map 5 there: what is seen afterwards belongs to 5."""
    await tell(client, 1.0)
    database = (await client.get("/backup")).content
    place = tmp_path / "other.db"
    place.write_bytes(database)
    with closing(sqlite3.connect(place)) as connection:
        connection.executescript(
            "UPDATE maps SET number = 5; UPDATE views SET map_number = 5; UPDATE things SET map_number = 5"
        )
    await restored(client, place.read_bytes())
    await tell(client, 2.0)
    again = (await client.get("/backup")).content
    assert rows_of(again, place, "SELECT count(*) FROM views WHERE map_number = 5") == 2
    assert rows_of(again, place, "SELECT count(*) FROM views") == 2


async def test_a_database_of_an_earlier_version_is_brought_to_the_newest(
    client: httpx.AsyncClient, tmp_path: Path
) -> None:
    from integration.memory.test_migrations import FIRST_VERSION

    place = tmp_path / "old.db"
    with closing(sqlite3.connect(place)) as connection:
        connection.executescript(FIRST_VERSION)
    reply = await restored(client, place.read_bytes())
    assert (reply.revision, reply.rows["views"]) == ("0001", 2)
    assert {one["label"] for one in (await client.get("/views")).json()} == {"bottle", "cup"}


def changed(*statements: str) -> Callable[[Path], bytes]:
    def made(place: Path) -> bytes:
        with closing(sqlite3.connect(place)) as connection:
            connection.executescript(";".join(statements))
        return place.read_bytes()

    return made


def rewritten(old: str, new: str) -> Callable[[Path], bytes]:
    """In the schema itself, as a file that somebody made by hand could have it."""
    return changed(
        "PRAGMA writable_schema = ON",
        f"UPDATE sqlite_master SET sql = replace(sql, '{old}', '{new}') WHERE type = 'table'",
    )


def cut(place: Path) -> bytes:
    data = place.read_bytes()
    return data[: len(data) // 2]


def spoilt(place: Path) -> bytes:
    data = bytearray(place.read_bytes())
    for at in range(4096 + 100, len(data), 97):
        data[at] ^= 0xFF
    return bytes(data)


HOSTILE: dict[str, tuple[Callable[[Path], bytes], str]] = {
    "nothing": (lambda place: b"", "no SQLite database"),
    "text": (lambda place: b"x" * 5000, "no SQLite database"),
    "a header alone": (lambda place: b"SQLite format 3\x00" + b"\x00" * 84, ""),
    "cut off": (cut, "damaged"),
    "spoilt": (spoilt, ""),
    "newer": (changed("UPDATE alembic_version SET version_num = '9999'"), "9999 of a newer program"),
    "another program's": (changed("DROP TABLE alembic_version"), "another program's tables"),
    "two versions": (changed("INSERT INTO alembic_version VALUES ('0002')"), "version is not readable"),
    "a trigger": (
        changed("CREATE TRIGGER t AFTER INSERT ON views BEGIN DELETE FROM things; END"),
        "holds what no database of ours does: trigger",
    ),
    "a view": (changed("CREATE VIEW v AS SELECT 1"), "no database of ours does: view"),
    "a virtual table": (changed("CREATE VIRTUAL TABLE v USING fts5(a)"), "no database of ours does"),
    "a table more": (changed("CREATE TABLE more (a INTEGER)"), "tables are not ours: more"),
    "a column more": (changed("ALTER TABLE maps ADD COLUMN a TEXT"), "tables are not ours: maps"),
    "an index less": (changed("DROP INDEX views_place"), "tables are not ours: views"),
    "a key of less": (
        changed("DROP INDEX views_place", "CREATE UNIQUE INDEX views_place ON views (map_number, x)"),
        "tables are not ours: views",
    ),
    "a key of other expressions": (
        changed(
            "DROP INDEX views_place",
            "CREATE UNIQUE INDEX views_place ON views"
            "(map_number, cell_x, cell_y, sector, label, colour, coalesce(thing_id, 1))",
        ),
        "tables are not ours: views",
    ),
    "an index of fewer rows": (
        changed(
            "DROP INDEX views_of_colour",
            "CREATE INDEX views_of_colour ON views (map_number, label, colour, confidence DESC) WHERE thing_id = 5",
        ),
        "tables are not ours: views",
    ),
    "a condition": (rewritten("NOT NULL", "NOT NULL CHECK (1)"), "tables are not ours: alembic_version, maps"),
    "a rule for conflicts": (rewritten("UNIQUE (id)", "UNIQUE (id) ON CONFLICT REPLACE"), "tables are not ours: maps"),
    "other deletions": (rewritten("ON DELETE SET NULL", "ON DELETE CASCADE"), "tables are not ours: things"),
    "text for a number": (changed("UPDATE views SET x = 'east'"), "another kind"),
    "infinite": (changed("UPDATE views SET y = 9e999"), "another kind"),
    "an orphan": (changed("UPDATE views SET thing_id = 77"), "names another one"),
    "beyond its bounds": (changed("UPDATE views SET confidence = 7.0"), "does not understand"),
    "without a map": (changed("DELETE FROM maps"), "it holds no map"),
    "in a map that is not there": (changed("UPDATE maps SET number = 9"), "are in a map 0 that it does not hold"),
    "a thing astray": (changed("UPDATE things SET map_number = 7"), "things are in a map 7"),
    **{
        f"a room {what}": (
            changed(f"INSERT INTO rooms (map_number, number, x, y, name) VALUES (0, {number}, {x}, 0.0, {name})"),
            said,
        )
        for what, number, x, name, said in (
            ("with a name of two lines", 1, 0.0, "'den' || char(10) || 'x'", "does not understand"),
            ("with too long a name", 1, 0.0, "hex(zeroblob(30))", "does not understand"),
            ("beyond every map", 1, 1e7, "'den'", "does not understand"),
            ("whose next has no number", 2**63 - 1, 0.0, "'den'", "has the number"),
        )
    },
    "without a label": (changed("UPDATE views SET label = ''"), "does not understand"),
}


@pytest.mark.parametrize("kind", HOSTILE)
async def test_what_is_not_a_sound_memory_is_refused_and_changes_nothing(
    client: httpx.AsyncClient, path: Path, tmp_path: Path, kind: str
) -> None:
    await tell(client, 1.0, 2.0)
    before = await told(client)
    place = tmp_path / "sent" / "sent.db"
    place.parent.mkdir()
    place.write_bytes((await client.get("/backup")).content)
    made, said = HOSTILE[kind]
    answer = await client.post("/restore", content=made(place))
    assert answer.status_code == 422, answer.text
    assert said in answer.json()["detail"]
    assert await told(client) == before
    assert {one.name for one in path.parent.glob("memory.db*")} <= {"memory.db", "memory.db-wal", "memory.db-shm"}


async def test_what_is_too_large_is_refused_before_it_is_all_here(path: Path) -> None:
    async with serving(f"sqlite:///{path}", restore_bytes_max=10_000) as client:
        await tell(client, 1.0)
        sent = 0

        async def endless() -> AsyncIterator[bytes]:
            nonlocal sent
            while True:
                sent += 4096
                yield b"SQLite format 3\x00" + bytes(4080)

        answer = await client.post("/restore", content=endless())
        assert answer.status_code == 413
        assert sent < 100_000
        assert not path.with_name("memory.db.candidate").exists()


async def test_an_object_is_forgotten_in_the_database_it_was_seen_in(
    client: httpx.AsyncClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Numbers of things are those of one database: a restore waits for whoever forgets one."""
    await tell(client, 1.0)
    database = (await client.get("/backup")).content
    (thing,) = (await client.get("/objects")).json()
    done: list[str] = []
    forgetting, restoring = asyncio.Event(), asyncio.Event()
    forget, replace, alone = SqlStore.forget_thing, SqlStore.replace, SharedLock.alone

    async def held_up(store: SqlStore, number: int) -> int:
        forgetting.set()
        await restoring.wait()
        for _ in range(20):  # so that a restore that did not wait would have begun
            await asyncio.sleep(0)
        done.append("forgotten")
        return await forget(store, number)

    def wanted(lock: SharedLock) -> AbstractAsyncContextManager[None]:
        restoring.set()
        return alone(lock)

    async def replaced(store: SqlStore, candidate: JudgedDatabase) -> str:
        done.append("replaced")
        return await replace(store, candidate)

    monkeypatch.setattr(SqlStore, "forget_thing", held_up)
    monkeypatch.setattr(SqlStore, "replace", replaced)
    monkeypatch.setattr(SharedLock, "alone", wanted)
    deleting = asyncio.create_task(client.delete(f"/objects/{thing['id']}"))
    await forgetting.wait()
    await restored(client, database)
    assert (await deleting).is_success
    assert done == ["forgotten", "replaced"]
    assert len((await client.get("/objects")).json()) == 1


async def test_where_the_robot_is_is_known_again_also_where_whoever_asked_for_the_restore_is_gone(
    client: httpx.AsyncClient, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    await tell(client, 1.0)
    place = tmp_path / "other.db"
    place.write_bytes((await client.get("/backup")).content)
    moved = changed("UPDATE maps SET number = 5; UPDATE views SET map_number = 5; UPDATE things SET map_number = 5")
    begun, replace = asyncio.Event(), SqlStore.replace

    async def replaced(store: SqlStore, candidate: JudgedDatabase) -> str:
        begun.set()
        return await replace(store, candidate)

    monkeypatch.setattr(SqlStore, "replace", replaced)
    restoring = asyncio.create_task(client.post("/restore", content=moved(place)))
    await begun.wait()
    restoring.cancel()
    await asyncio.gather(restoring, return_exceptions=True)
    await tell(client, 2.0)
    again = (await client.get("/backup")).content
    assert rows_of(again, place, "SELECT count(*) FROM views WHERE map_number = 5") == 2


async def test_a_second_copy_waits_for_its_own_turn(client: httpx.AsyncClient) -> None:
    await tell(client, 1.0)
    go_on, begun = asyncio.Event(), asyncio.Event()

    async def slow() -> AsyncIterator[bytes]:
        yield b"SQLite format 3\x00"
        begun.set()
        await go_on.wait()

    first = asyncio.create_task(client.post("/restore", content=slow()))
    await begun.wait()
    assert (await client.get("/backup")).status_code == 409
    assert (await client.post("/restore", content=b"x")).status_code == 409
    go_on.set()
    assert (await first).status_code == 422


async def test_another_program_that_writes_the_file_holds_a_restore_up_and_nothing_changes(path: Path) -> None:
    async with serving(f"sqlite:///{path}", busy_timeout_s=0.2) as client:
        await tell(client, 1.0)
        database = (await client.get("/backup")).content
        await tell(client, 2.0)
        before = await told(client)
        with closing(sqlite3.connect(path, isolation_level=None)) as other:
            other.execute("BEGIN IMMEDIATE")
            answer = await client.post("/restore", content=database)
            assert (answer.status_code, answer.json()["detail"]) == (503, "database: another program writes it")
        assert await told(client) == before
        assert not list(path.parent.glob("*before-restore*"))


async def test_a_memory_in_postgresql_names_its_own_tool(postgres_url: str) -> None:
    async with serving(fresh_database(postgres_url, "copied")) as client:
        for answer in (await client.get("/backup"), await client.post("/restore", content=b"x")):
            assert (answer.status_code, answer.json()["code"]) == (422, BackupRefusal.USE_PG_DUMP.value)
            assert "pg_dump" in answer.json()["detail"]


def files_without_a_name() -> list[str]:
    """What this process has open that lies on no disk any more but for it."""
    folder = Path("/proc/self/fd")
    return [name for one in folder.iterdir() if (name := _target(one)).endswith(".snapshot (deleted)")]


def _target(link: Path) -> str:
    try:
        return str(link.readlink())
    except FileNotFoundError:  # of the listing itself
        return ""


async def test_the_disk_of_a_back_up_that_nobody_takes_is_let_go(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(server, "ANSWER_WAIT_S_MAX", 1.0)
    app = create_app(
        Settings.model_validate({"database_url": f"sqlite:///{path}", "robot_bridge_url": ""}), bus=described_bus()
    )
    async with served(app) as url, httpx.AsyncClient(base_url=url, trust_env=False) as client:
        assert (await client.get("/maps")).is_success
        with closing(sqlite3.connect(path)) as connection, connection:  # more than the system keeps for a socket
            connection.execute("CREATE TABLE filler AS SELECT zeroblob(30000000) AS filling")
        reader, writer = await asyncio.open_connection("127.0.0.1", client.base_url.port, limit=1024)
        writer.write(b"GET /backup HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
        assert (await reader.readline()).startswith(b"HTTP/1.1 200")
        assert len(files_without_a_name()) == 1
        await until(lambda: files_without_a_name() == [])
        writer.close()
