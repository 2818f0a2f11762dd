"""What stands there when an episode begins: the home as it has become, the robot in it, what lies on its disk."""

import contextlib
import shutil
import tempfile
import time
from collections.abc import Generator
from dataclasses import dataclass
from pathlib import Path

from bench.search.episode import Episode
from bench.search.policies import deciding
from bench.world.drawn import drawn_from
from bench.world.mesh import MeshSettings
from bench.world.tour import toured
from inference.perception.models import Loaded
from sim.home import Home
from sim.world import OccupancyGrid, World, WorldOptions


@dataclass(frozen=True)
class Staged:
    """`recorded`: the map it has, older than the home is now. `settings` name its disk, which is gone afterwards."""

    world: World
    recorded: OccupancyGrid
    settings: MeshSettings
    toured_cpu_s: float


@contextlib.contextmanager
def staged(episode: Episode, models: Loaded, settings: MeshSettings, tours: Path) -> Generator[Staged]:
    """What is drawn meanwhile is drawn from the episode's seed. `settings.disk` is not used."""
    began_cpu_s = time.process_time()
    home = Home.generate(episode.home_seed)
    remembered = toured(home, models, settings, tours) if episode.tour else None
    toured_cpu_s = time.process_time() - began_cpu_s
    with tempfile.TemporaryDirectory() as scratch, World(home) as before, drawn_from(episode.seed):
        recorded, disk = before.grid, Path(scratch) / "disk"
        if remembered is None:
            disk.mkdir()
        else:
            shutil.copytree(remembered, disk)
        rules = deciding(settings.coordinator, episode.policy, episode.changes)
        ours = MeshSettings(disk, rules, settings.inference, settings.memory, settings.bridge)
        for carried in episode.since_tour:
            home = carried.done_to(home)
        options = WorldOptions(light=episode.light, rgb_noise_sigma=episode.grain)
        with World(home, seed=episode.seed, start=episode.start, options=options) as world:
            yield Staged(world, recorded, ours, toured_cpu_s)
