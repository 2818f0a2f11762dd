"""Each command of README.md and docs/ is run here, as written, from an empty environment; or a table says why not."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from support.doc_commands import BESIDE_A_MESH, NOT_RUN, PAGES, beside_a_mesh, blocks, commands, is_run
from support.source import ROOT


@pytest.mark.parametrize("page", [one for one in PAGES if any(map(is_run, commands(one)))], ids=lambda one: one.stem)
def test_the_commands_of_a_page_do_what_they_say(page: Path, tmp_path: Path) -> None:
    (tmp_path / ".venv").symlink_to(ROOT / ".venv")
    shutil.copy(ROOT / "Makefile", tmp_path)
    (tmp_path / ".config").mkdir()
    (tmp_path / ".config/atom.key").write_text("a key")
    script = "\n".join(["set -eu", *filter(is_run, commands(page))])
    done = subprocess.run(
        ["bash", "-c", script], cwd=tmp_path, env={"PATH": os.defpath, "HOME": str(tmp_path)},
        stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert done.returncode == 0, f"{done.stdout}\n{done.stderr}\nA command that cannot be run here stands in NOT_RUN."


@pytest.mark.parametrize("page", [one for one in PAGES if blocks(one)], ids=lambda one: one.stem)
def test_every_block_is_a_script_that_a_shell_reads(page: Path) -> None:
    done = subprocess.run(["bash", "-n"], input="\n".join(blocks(page)), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_the_table_names_no_command_that_is_gone() -> None:
    assert set(NOT_RUN) - {one for page in PAGES for one in commands(page)} == set()


def test_each_page_that_is_said_to_need_a_mesh_has_commands_for_one() -> None:
    assert {page.name for page in PAGES if beside_a_mesh(page)} == set(BESIDE_A_MESH)
