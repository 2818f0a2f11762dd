"""The main job, as a person starts it: `make demo ONCE=1`, judged by ground truth."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

KEYS = {
    "command", "seed", "outcome", "seconds", "metres", "votes", "measured_distance_m", "true_distance_m", "correct",
}  # fmt: skip


@pytest.mark.timeout(900)
def test_the_robot_finds_the_red_bottle(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "demo", "run", "--once", "--port-base", "18400", "--seed", "0"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=850,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-6000:]
    told = json.loads((tmp_path / "out/demo/mission.json").read_text())
    assert set(told) >= KEYS
    assert (told["outcome"], told["correct"]) == ("found", True)
    assert {vote["voter"] for vote in told["votes"]} == {"detector", "clip", "vlm"}
    assert (tmp_path / "out/demo/frame.jpg").stat().st_size > 1000
    assert (tmp_path / "out/demo/map.png").stat().st_size > 1000
