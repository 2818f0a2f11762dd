"""The whole mesh with the simulated robot, started once a module: two of them at a time are too much for two cores."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from demo.ready import wait_until_ready
from demo.stack import Ports, Stack
from sim.home import Home, Wanted
from support.mesh_run import MeshRun

PORT_BASE = 18200


@pytest.fixture(scope="module")
def mesh(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[MeshRun]:
    """In a home that holds a red bottle, with an empty memory; with the speech service where a module says SPEECH, and
    with the settings it names in SETTINGS.
    """
    folder: Path = tmp_path_factory.mktemp("mesh")
    stack = Stack(
        Ports(PORT_BASE), folder, folder / "home.json", seed=3, speech=getattr(request.module, "SPEECH", False)
    )
    Home.generate(3, wanted=Wanted("bottle", "red")).save(stack.home)
    with pytest.MonkeyPatch.context() as environment:
        for name, value in getattr(request.module, "SETTINGS", {}).items():
            environment.setenv(name, value)
        process = stack.start()
    try:
        wait_until_ready(
            stack, timeout_s=240.0, on_ready=lambda part, seconds: None, alive=lambda: process.poll() is None
        )
        with MeshRun(stack) as run:
            yield run
    finally:
        stack.stop(process)
