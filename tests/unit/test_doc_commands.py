"""Each command of README.md and docs/ is run here, as written, from an empty environment; or a table says why not."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from markdown_it import MarkdownIt

from support.source import ROOT

MESH = "needs a running mesh"
ROBOT = "needs a robot, or its ROS packages"
STAYS = "stays until it is ended"
LONG = "takes minutes, and installs: the gate (.ci/run) and tests/e2e play it"
NOT_RUN = {
    "ROS_DOMAIN_ID=0 ROBOT_BRIDGE_ROS__CMD_VEL_NAV__NAME=cmd_vel_to_bridge python -m robot_bridge": ROBOT,
    ".venv/bin/atom keys make anna --password": "asks for a password; tests/contract/cli play it",
    "ATOM_KEY_FILE=~/.config/atom.key atom find \"red bottle\"": MESH,
    ".venv/bin/atom backup atom-backup.tar": MESH,
    ".venv/bin/atom backup before-the-update.tar": MESH,
    ".venv/bin/atom find \"blue cup\"": MESH,
    ".venv/bin/atom memory": MESH,
    ".venv/bin/atom restore --check atom-backup.tar": MESH,
    ".venv/bin/atom restore atom-backup.tar": MESH,
    ".venv/bin/atom resume": MESH,
    ".venv/bin/atom status": MESH,
    "INFERENCE_MODEL_SET=coco python -m inference": "needs weights that are fetched by hand",
    "git pull": "fetches",
    "make demo": LONG,
    "make demo COMMAND=\"find the blue cup\" SEED=4": LONG,
    "make demo ONCE=1": LONG,
    "make demo SPEECH=1": LONG,
    "ROBOT_BRIDGE_FOXGLOVE_PORT=8765 make demo": LONG,
    "ssh -N -L 8765:127.0.0.1:8765 robot": ROBOT,
    "make demo TOUR=0": LONG,
    "make doctor": ROBOT,
    "make setup": LONG,
    "make setup && . .venv/bin/activate": LONG,
    "make test": LONG,
    "make up; make down": LONG,
    "python -m memory; python -m coordinator; python -m ui": STAYS,
    "redis-server --aclfile keys/redis.acl": STAYS,
    "redis-server --save \"\" &": STAYS,
}  # fmt: skip
NOT_RUN_ALL = {
    r"((ATOM_SITE|UI_SPEECH_URL)=\S+ )*docker compose .*": "needs Docker",
    r"echo '.*' >> \.env": "is for docker compose",
    r"ros2 .*": ROBOT,
    r"([ER]=\$\()?curl .*": MESH,
}
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def blocks(page: Path) -> list[str]:
    """What the page tells its reader to type."""
    found = MarkdownIt().parse(page.read_text(encoding="utf-8"))
    return [
        one.content for one in found if one.type == "fence" and one.info.strip() in {"sh", "bash", "console", "shell"}
    ]


def commands(page: Path) -> list[str]:
    """One after another, without the remarks behind them; a quote may go over several lines."""
    text = "\n".join(blocks(page)).replace("\\\n", " ")
    text = re.sub(r"(^|\s+)# .*$", "", text, flags=re.MULTILINE)
    return [one.strip() for one in re.findall(r"(?:'[^']*'|[^'\n])+", text) if one.strip()]


def is_run(command: str) -> bool:
    return command not in NOT_RUN and not any(re.fullmatch(one, command, re.DOTALL) for one in NOT_RUN_ALL)


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
