"""The pages' commands that need a running mesh, as written but for the ports, beside the real one."""

import os
import re
import subprocess
from pathlib import Path

import pytest

from support.doc_commands import PAGES, beside_a_mesh
from support.mesh_run import MeshRun
from support.source import ROOT

ADDRESS = re.compile(r"\b(?:localhost|127\.0\.0\.1|ROBOT):80(0[1-6])\b")
"""`ROBOT` stands for its name in a network."""


@pytest.fixture
def at_rest(mesh: MeshRun) -> MeshRun:
    mesh.post("robot_bridge", "/emergency-stop/reset").raise_for_status()
    mesh.rested()
    return mesh


@pytest.mark.parametrize("page", [one for one in PAGES if beside_a_mesh(one)], ids=lambda one: one.stem)
def test_the_commands_of_a_page_are_answered_by_a_running_mesh(page: Path, at_rest: MeshRun, tmp_path: Path) -> None:
    (tmp_path / ".venv").symlink_to(ROOT / ".venv")
    (tmp_path / ".curlrc").write_text("fail\nsilent\nshow-error\n")  # what is refused fails
    (tmp_path / ".config").mkdir()
    (tmp_path / ".config/atom.key").write_text("a key")
    (tmp_path / ".config/atom.header").write_text("Authorization: Bearer a key")
    base = at_rest.ports.base
    script = "\n".join(["set -eu", *beside_a_mesh(page)])
    script = ADDRESS.sub(lambda found: f"127.0.0.1:{base + int(found[1])}", script)
    environment = {
        "PATH": f"{ROOT / '.venv/bin'}:{os.defpath}",
        "HOME": str(tmp_path),
        "KEY": "a-key",
        "ATOM_PORT_BASE": str(base),
    }
    done = subprocess.run(
        ["bash", "-c", script], cwd=tmp_path, env=environment,
        input="y\n", capture_output=True, text=True, timeout=120, check=False,  # yes: let it move again
    )  # fmt: skip
    assert done.returncode == 0, f"{script}\n{done.stdout}\n{done.stderr}"
