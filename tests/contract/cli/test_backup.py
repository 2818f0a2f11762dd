"""`atom backup` and `atom restore` against the real memory and coordinator, over sockets; and against bad archives."""

import asyncio
import sqlite3
import tarfile
from collections.abc import AsyncIterator, Callable
from contextlib import aclosing, asynccontextmanager, closing
from pathlib import Path

import httpx
import pytest
from typer.testing import CliRunner, Result

from atom_cli import __main__ as cli
from atom_cli import archive
from contracts.backup import BackupRefusal, BackupService
from contracts.exploration import Discovery, ExplorationMemory
from contracts.memory import ObservationBatch
from contracts.mission import Mission, MissionState, MissionStatus
from coordinator import app as coordinator
from coordinator.adapters.exploration_journal import ExplorationJournal
from coordinator.settings import Settings as CoordinatorSettings
from memory import app as memory
from memory.settings import Settings as MemorySettings
from support.bus import MemoryBus
from support.coordinator_world import FakeInference, FakeMemory, FakeRobot, World
from support.described import described_bus
from support.fake_clock import FakeClock
from support.observations import seen
from support.served import served

PORTS = {8001: "coordinator", 8003: "memory"}


class Wire(httpx.BaseTransport):
    """Sends what is for 8001 and 8003 to where the services are; `refused` answers for a service, asked so often."""

    def __init__(self, urls: dict[str, str]) -> None:
        self.urls = urls
        self.asked: list[tuple[str, str, str]] = []
        self.refuse: Callable[[str, str, bool], httpx.Response | None] = lambda service, path, dry_run: None
        self._http = httpx.HTTPTransport()

    def handle_request(self, request: httpx.Request) -> httpx.Response:
        service = PORTS[request.url.port or 0]
        dry_run = request.url.params.get("dry_run") == "true"
        self.asked.append((service, request.url.path, "checked" if dry_run else ""))
        refusal = self.refuse(service, request.url.path, dry_run)
        if refusal is not None:
            return refusal
        request.url = httpx.URL(self.urls[service]).copy_with(raw_path=request.url.raw_path)
        request.headers["host"] = request.url.netloc.decode()
        return self._http.handle_request(request)

    def close(self) -> None:
        self._http.close()


class Mesh:
    def __init__(self, wire: Wire, folder: Path) -> None:
        self.wire = wire
        self.folder = folder
        self.http = httpx.AsyncClient(trust_env=False)

    async def atom(self, *arguments: str) -> Result:
        return await asyncio.to_thread(CliRunner().invoke, cli.app, list(arguments))

    async def see(self, label: str) -> None:
        batch = ObservationBatch(observations=(seen(label, 1.0, stamp_s=1.7e9, at=(1.0, 1.0)),))
        await self.http.post(f"{self.wire.urls['memory']}/observations", json=batch.model_dump(mode="json"))

    async def explore(self, label: str) -> None:
        """As an exploration of before would have left it in the file."""
        async with aclosing(ExplorationJournal(self.folder / "exploration.db", busy_timeout_s=1.0)) as journal:
            found = Discovery(label=label, note="", x_m=1.0, y_m=2.0, stamp_s=3.0)
            journal.write("flat", ExplorationMemory(discoveries=(found,)))

    async def explored(self) -> list[str]:
        async with aclosing(ExplorationJournal(self.folder / "exploration.db", busy_timeout_s=1.0)) as journal:
            return [one.label for one in (await journal.read("flat")).discoveries]

    async def told(self) -> tuple[str, object]:
        missions = await self.http.get(f"{self.wire.urls['coordinator']}/missions")
        return (await self.http.get(f"{self.wire.urls['memory']}/export")).text, missions.json()

    def remember_mission(self, name: str) -> None:
        """As a mission of before would be in the file."""
        record = Mission(id=name, command="find it", state=MissionState.IDLE, started_s=1.0).model_dump_json()
        with closing(sqlite3.connect(self.folder / "coordinator.db")) as connection, connection:
            connection.execute("INSERT INTO missions (id, over, record) VALUES (?, 1, ?)", (name, record))


@pytest.fixture
async def mesh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Mesh]:
    async with opened(tmp_path) as one:
        monkeypatch.setattr(cli, "transport", one.wire)
        yield one


@asynccontextmanager
async def opened(folder: Path) -> AsyncIterator[Mesh]:
    clock, bus = FakeClock(), described_bus()
    world = World(clock, bus)
    deciding = coordinator.create_app(
        CoordinatorSettings.model_validate({"database_url": f"sqlite:///{folder}/coordinator.db", "flush_s": 0.01}),
        bus=bus, robot=FakeRobot(world), inference=FakeInference(world), memory=FakeMemory(), clock=clock,
    )  # fmt: skip
    remembering = memory.create_app(
        MemorySettings(database_url=f"sqlite:///{folder}/memory.db", robot_bridge_url=""), bus=MemoryBus()
    )
    async with served(deciding) as first, served(remembering) as second:
        mesh = Mesh(Wire({"coordinator": first, "memory": second}), folder)
        await mesh.told()  # both have made their databases
        yield mesh
        await mesh.http.aclose()


def files(folder: Path) -> set[str]:
    return {one.name for one in folder.iterdir()}


def mode_of(file: str) -> int:
    return Path(file).stat().st_mode


async def test_what_is_backed_up_comes_back_exactly(mesh: Mesh, tmp_path: Path) -> None:
    await mesh.see("bottle")
    mesh.remember_mission("first")
    before, file = await mesh.told(), str(tmp_path / "copy.tar")
    made = await mesh.atom("backup", file)
    assert made.exit_code == 0, made.output
    assert mode_of(file) & 0o077 == 0
    await mesh.see("cup")
    mesh.remember_mission("second")
    after = await mesh.told()
    checked = await mesh.atom("restore", file, "--check")
    assert (checked.exit_code, "nothing was changed" in checked.output) == (0, True), checked.output
    assert await mesh.told() == after != before
    done = await mesh.atom("restore", file, "--yes")
    assert done.exit_code == 0, done.output
    assert await mesh.told() == before
    assert sorted(one for one in files(tmp_path) if not one.endswith(("-wal", "-shm"))) == [
        "coordinator.db", "coordinator.db.before-restore-1", "copy.tar", "exploration.db",
        "exploration.db.before-restore-1", "memory.db", "memory.db.before-restore-1",
    ]  # fmt: skip


async def test_what_was_explored_of_a_home_is_read_again_after_a_restore(mesh: Mesh, tmp_path: Path) -> None:
    await mesh.explore("cup")
    file = str(tmp_path / "copy.tar")
    made = await mesh.atom("backup", file)
    assert made.exit_code == 0, made.output
    await mesh.explore("book")
    only = await mesh.atom("restore", file, "--yes", "--only", "memory")
    assert (only.exit_code, await mesh.explored()) == (0, ["book"])
    done = await mesh.atom("restore", file, "--yes", "--only", "exploration")
    assert (done.exit_code, "1 explorations" in done.output) == (0, True), done.output
    assert await mesh.explored() == ["cup"]


async def test_an_archive_of_before_leaves_what_was_explored_alone(mesh: Mesh, tmp_path: Path) -> None:
    file = str(tmp_path / "copy.tar")
    await mesh.atom("backup", file, "--only", "memory", "--only", "coordinator")
    await mesh.explore("cup")
    done = await mesh.atom("restore", file, "--yes")
    assert done.exit_code == 0, done.output
    assert await mesh.explored() == ["cup"]


async def test_one_service_alone(mesh: Mesh, tmp_path: Path) -> None:
    await mesh.see("bottle")
    file = str(tmp_path / "copy.tar")
    assert (await mesh.atom("backup", file, "--only", "memory")).exit_code == 0
    assert (await mesh.atom("backup", file)).exit_code == 2  # it is there already
    lacking = await mesh.atom("restore", file, "--yes", "--only", "coordinator")
    assert (lacking.exit_code, "nothing of coordinator" in lacking.output) == (3, True)
    assert (await mesh.atom("restore", file, "--yes")).exit_code == 0
    with tarfile.open(file) as tar:  # any tar reads it
        assert tar.getnames() == ["manifest.json", "memory.db"]


async def test_memory_alone_is_not_exchanged_under_a_mission(mesh: Mesh, tmp_path: Path) -> None:
    file = str(tmp_path / "copy.tar")
    await mesh.atom("backup", file, "--only", "memory")
    state = MissionState.SCANNING
    its = Mission(id="a", command="find it", state=state, started_s=1.0)
    running = MissionStatus(state=state, stamp_s=1.0, mission=its)
    mesh.wire.refuse = lambda service, path, dry_run: (
        httpx.Response(200, json=running.model_dump(mode="json")) if path == "/state" else None
    )
    refused = await mesh.atom("restore", file, "--yes")
    assert (refused.exit_code, "a mission runs" in refused.output) == (3, True)
    assert ("memory", "/restore", "") not in mesh.wire.asked


async def test_no_mission_begins_between_the_first_service_and_the_second(mesh: Mesh, tmp_path: Path) -> None:
    file = str(tmp_path / "copy.tar")
    await mesh.atom("backup", file)
    url = mesh.wire.urls["coordinator"]
    between: list[httpx.Response] = []

    def ask(service: str, path: str, dry_run: bool) -> None:
        if (service, path, dry_run) == ("memory", "/restore", False):
            between.append(httpx.post(f"{url}/missions", json={"command": "find the red bottle"}, trust_env=False))

    mesh.wire.refuse = ask  # type: ignore[assignment]
    done = await mesh.atom("restore", file, "--yes")
    assert done.exit_code == 0, done.output
    assert [(one.status_code, one.json()["code"]) for one in between] == [(409, BackupRefusal.RESTORING.value)]
    afterwards = await mesh.http.post(f"{url}/missions", json={"command": "find the red bottle"})
    assert afterwards.json().get("code") != BackupRefusal.RESTORING.value, afterwards.text


async def test_memory_alone_is_restored_where_no_coordinator_is(mesh: Mesh, tmp_path: Path) -> None:
    await mesh.see("bottle")
    file = str(tmp_path / "copy.tar")
    await mesh.atom("backup", file, "--only", "memory")

    def away(service: str, path: str, dry_run: bool) -> None:
        if service == "coordinator":
            raise httpx.ConnectError("refused")

    mesh.wire.refuse = away  # type: ignore[assignment]
    done = await mesh.atom("restore", file, "--yes")
    assert done.exit_code == 0, done.output


async def test_what_the_second_does_not_take_the_first_gives_back(mesh: Mesh, tmp_path: Path) -> None:
    await mesh.see("bottle")
    mesh.remember_mission("first")
    file = str(tmp_path / "copy.tar")
    await mesh.atom("backup", file)
    await mesh.see("cup")
    mesh.remember_mission("second")
    before = await mesh.told()
    full = httpx.Response(503, json={"title": "away", "status": 503, "detail": "database: the disk is full"})
    mesh.wire.refuse = lambda service, path, dry_run: (
        full if (service, path, dry_run) == ("memory", "/restore", False) else None
    )
    failed = await mesh.atom("restore", file, "--yes")
    assert failed.exit_code == 3
    assert "the disk is full. coordinator and exploration have again what they had before" in failed.output
    assert await mesh.told() == before
    assert [one for one in mesh.wire.asked if one[1].endswith("/restore")][:3] == [
        ("coordinator", "/restore", "checked"),
        ("coordinator", "/exploration/restore", "checked"),
        ("memory", "/restore", "checked"),
    ]


@pytest.mark.parametrize("stopped", [httpx.ReadTimeout("slow"), KeyboardInterrupt()], ids=["timeout", "interrupt"])
@pytest.mark.parametrize("at", ["coordinator", "memory"])
async def test_of_a_service_that_nobody_waits_for_any_longer_nobody_says_that_nothing_changed(
    mesh: Mesh, tmp_path: Path, at: str, stopped: BaseException
) -> None:
    file = str(tmp_path / "copy.tar")
    await mesh.atom("backup", file)

    def stop(service: str, path: str, dry_run: bool) -> None:
        if (service, path, dry_run) == (at, "/restore", False):
            raise stopped

    mesh.wire.refuse = stop  # type: ignore[assignment]
    failed = await mesh.atom("restore", file, "--yes")
    assert failed.exit_code == (130 if isinstance(stopped, KeyboardInterrupt) else 4), failed.output
    assert f"{at} may have taken it, or still will: look." in failed.output
    assert ("coordinator and exploration have again what they had before" in failed.output) is (at == "memory")


async def test_what_either_does_not_believe_changes_neither(mesh: Mesh, tmp_path: Path) -> None:
    await mesh.see("bottle")
    good, bad = tmp_path / "good.tar", tmp_path / "bad.tar"
    await mesh.atom("backup", str(good))
    folder = tmp_path / "files"
    folder.mkdir()
    manifest, its = archive.unpack(good, folder)
    with closing(sqlite3.connect(its[BackupService.MEMORY])) as connection, connection:
        connection.execute("UPDATE alembic_version SET version_num = '9999'")
    archive.write(bad, manifest.made_s, [(one.service, one.revision, its[one.service]) for one in manifest.databases])
    before = await mesh.told()
    refused = await mesh.atom("restore", str(bad), "--yes")
    assert (refused.exit_code, "9999 of a newer program" in refused.output) == (3, True)
    assert await mesh.told() == before
    assert not [one for one in files(tmp_path) if "before-restore" in one]


async def test_a_service_that_is_away_leaves_no_archive(mesh: Mesh, tmp_path: Path) -> None:
    def away(service: str, path: str, dry_run: bool) -> None:
        if service == "memory":
            raise httpx.ConnectError("refused")

    mesh.wire.refuse = away  # type: ignore[assignment]
    failed = await mesh.atom("backup", str(tmp_path / "copy.tar"))
    assert (failed.exit_code, "memory is not reachable" in failed.output) == (4, True)
    assert not [one for one in files(tmp_path) if "copy" in one or one.startswith(".atom")]
