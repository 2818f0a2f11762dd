"""A slice of the fault campaign, the failures the source documents name, and missions decided again."""

import asyncio
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from bench.campaigning.episode import FaultedEpisode, faulted
from bench.campaigning.play import played
from bench.search.running import loaded, prepare_exports
from bench.world.clock import NothingLeftError, run_simulated
from bench.world.faults import Errors, Faults
from bench.world.mesh import MeshSettings
from contracts.mission import Outcome
from coordinator import replay
from coordinator.core.recording import MalformedRecordingError, read
from inference.perception.models import Loaded
from support.source import ROOT

SLICE = (4, 11)
"""Missions of the campaign that need no tour, which takes as long as they do; `make bench-campaign` plays hundreds."""
UNSEEN = 4
"""A mission in a home without a tour."""
pytestmark = pytest.mark.timeout(900)


@pytest.fixture(scope="module")
def models() -> tuple[Loaded, MeshSettings]:
    prepare_exports("sim")
    return loaded("sim")


@pytest.fixture(scope="module")
def tours(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("tours")


def one(faults: Faults, **changes: Any) -> FaultedEpisode:
    return faulted(UNSEEN, faults=faults, policy="belief", **changes)


def ended(record: dict[str, Any], outcome: Outcome) -> str:
    """The reason of a mission that ended so, safely and honestly."""
    assert record["problems"] == []
    assert record["dishonest"] == ""
    assert record["ending"] == outcome.value, record["mission"]["reason"]
    return record["mission"]["reason"]


@pytest.mark.parametrize("seed", SLICE)
def test_missions_with_faults_end_safely_and_honestly(
    models: tuple[Loaded, MeshSettings], tours: Path, seed: int
) -> None:
    record = played(faulted(seed), *models, tours=tours)
    assert record["problems"] == []
    assert record["dishonest"] == "", record["mission"]["reason"]


def test_navigation_that_never_works_ends_with_that_as_the_cause(
    models: tuple[Loaded, MeshSettings], tours: Path
) -> None:
    faults = Faults(names=("Nav2 aborts 2xx",), goal_aborted_2xx=1.0, errors=Errors(missed=1.0))
    record = played(one(faults), *models, tours=tours)
    assert "navigation reached none of 12 places in a row" in ended(record, Outcome.ABORTED)
    assert record["metres"] < 1.0


def test_a_liar_among_the_voters_is_outvoted_or_named(models: tuple[Loaded, MeshSettings], tours: Path) -> None:
    faults = Faults(names=("a lying detector",), errors=Errors(liar="detector"))
    record = played(one(faults), *models, tours=tours)
    assert record["problems"] == []
    assert record["dishonest"] == ""


def test_the_same_seed_is_the_same_mission(models: tuple[Loaded, MeshSettings], tours: Path) -> None:
    faults = Faults(bus_drop=0.2, bus_delay_s_max=0.5, reply_delay_s_max=1.0, cancel_s=20.0, errors=Errors(missed=0.3))
    first, second = (played(one(faults), *models, tours=tours) for _ in range(2))
    assert first["digest"] == second["digest"]
    ended(first, Outcome.CANCELED)


def test_a_recorded_mission_is_decided_again_step_by_step(
    models: tuple[Loaded, MeshSettings], tours: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    record = played(one(Faults(bus_duplicate=0.2, cancel_s=25.0)), *models, tours=tours, recording=tmp_path / "m.jsonl")
    ended(record, Outcome.CANCELED)
    path = tmp_path / "m.jsonl"
    lines = path.read_text(encoding="utf-8").splitlines()
    monkeypatch.setattr("sys.argv", ["replay", str(path)])
    assert replay.main() == 0
    shown = capsys.readouterr().out
    steps = len(read(lines).steps)
    assert f"{steps} of {steps} steps decided as recorded" in shown
    other = lines[0].replace('"coverage_rule":"belief"', '"coverage_rule":"lawnmower"')
    assert other != lines[0]
    path.write_text("\n".join([other, *lines[1:]]), encoding="utf-8")
    assert replay.main() == 1
    assert "RECORDED" in capsys.readouterr().out


def test_worker_processes_find_what_they_are_to_play(models: tuple[Loaded, MeshSettings], tmp_path: Path) -> None:
    asked = ("-m", "bench.campaigning", "--out", str(tmp_path), "play", "--missions", "1", "--jobs", "1")
    over = subprocess.run(
        (sys.executable, *asked, "--minutes", "0"), cwd=ROOT, capture_output=True, text=True, timeout=300, check=False
    )
    assert over.returncode == 0, over.stderr
    assert '"missions": 0' in over.stdout


def test_a_file_that_is_no_recording_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "mission.jsonl"
    path.write_text("no recording", encoding="utf-8")
    monkeypatch.setattr("sys.argv", ["replay", str(path)])
    assert replay.main() == 2
    assert capsys.readouterr().err
    with pytest.raises(MalformedRecordingError):
        read([])


def test_a_hang_does_not_go_unnoticed() -> None:
    async def for_ever() -> None:
        await asyncio.Event().wait()

    with pytest.raises(NothingLeftError):
        run_simulated(for_ever)
