"""One episode through the whole mesh in one process: it goes on as on the robot, and twice the same bit for bit."""

from pathlib import Path

import pytest

from bench.search.episode import Episode
from bench.search.play import played
from bench.search.sets import TUNE_HOMES, episode
from bench.world.mesh import MeshSettings
from coordinator.settings import Settings as CoordinatorSettings
from inference.adapters.loading import loader
from inference.perception.models import Loaded
from inference.settings import Backend, Settings
from support.source import ROOT

PATIENCE_S = 4.0


@pytest.fixture(scope="module")
def settings() -> MeshSettings:
    inference = Settings(
        detector_path=ROOT / "sim/weights/detector.pt",
        detector_backend=Backend.TORCH,
        clip_path=ROOT / "sim/weights/clip.safetensors",
    )
    return MeshSettings(Path(), CoordinatorSettings(mission_timeout_s=PATIENCE_S), inference)


@pytest.fixture(scope="module")
def models(settings: MeshSettings) -> Loaded:
    return loader(settings.inference)()


@pytest.fixture(scope="module")
def short() -> Episode:
    return episode("unseen", 0, TUNE_HOMES)


@pytest.mark.timeout(300)
def test_an_episode_goes_on_as_on_the_robot_and_twice_the_same(
    models: Loaded, settings: MeshSettings, short: Episode, tmp_path: Path
) -> None:
    first = played(short, models, settings, tours=tmp_path)
    (row,) = first["missions"]
    assert first["problems"] == []
    assert row["outcome"] == "not_found"
    assert PATIENCE_S <= row["seconds"] < PATIENCE_S + 5.0
    assert row["there"]
    assert first["calls"]["inference GET robot_bridge/camera/frame"] > 10
    assert first["calls"]["coordinator POST robot_bridge/rotate"] > 0
    assert first["activity"]["SCANNING: turn"] > 0.0

    again = played(Episode.model_validate(first["episode"]), models, settings, tours=tmp_path)
    assert again["digest"] == first["digest"]
