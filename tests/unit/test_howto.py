"""Each page of docs/how-to is done to a copy of the source: its diff applies, and the test it brings passes."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import settings_page

from support.source import ROOT

PAGES = ROOT / "docs/how-to"
DIFF = re.compile(r"^```diff\n(.*?)^```$", re.MULTILINE | re.DOTALL)
CHANGES = sorted(path for path in PAGES.glob("*.md") if DIFF.search(path.read_text(encoding="utf-8")))


@pytest.mark.parametrize("page", CHANGES, ids=lambda path: path.stem)
def test_the_change_applies_and_its_test_passes(page: Path, tmp_path: Path) -> None:
    (diff,) = DIFF.findall(page.read_text(encoding="utf-8"))
    for name in sorted(set(re.findall(r"^(?:---|\+\+\+) (\w+/\w+/src)/", diff, re.MULTILINE))):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    git = subprocess.run(
        ["git", "apply", "-p0", "-"], cwd=tmp_path, input=diff, text=True, capture_output=True, check=False
    )
    assert git.returncode == 0, git.stderr
    sources = os.pathsep.join(str(path) for path in tmp_path.glob("*/*/src"))
    tried = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--rootdir", ".", "-c", os.devnull, "tests"],
        cwd=tmp_path, env=os.environ | {"PYTHONPATH": sources}, text=True, capture_output=True, check=False,
    )  # fmt: skip
    assert tried.returncode == 0, tried.stdout[-2000:]


def test_the_five_pages_are_there() -> None:
    assert len(CHANGES) == 4
    assert (PAGES / "another-robot.md").exists()


def test_another_robot_is_settings_that_the_services_know_and_take(monkeypatch: pytest.MonkeyPatch) -> None:
    said = dict(re.findall(r"^([A-Z_]+)=(.+)$", (PAGES / "another-robot.md").read_text(encoding="utf-8"), re.MULTILINE))
    services = [settings_page.settings_of(service) for service in settings_page.SERVICES]
    known = {name for settings in services for name, _, _ in settings_page.variables(settings)}
    assert {name.removesuffix("__NAME") for name in said} <= known, "a topic is one setting, its name a part of it"
    for name, value in said.items():
        monkeypatch.setenv(name, value)
    told = " ".join(str(settings()) for settings in services)
    assert [value for value in said.values() if value not in told] == []
