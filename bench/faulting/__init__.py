"""The parts of `bench.faults`: what stands between the robot and the bridge, and what floods it.

The running mesh is looked at as the end-to-end tests do it (`tests/support/mesh_run.py`).
"""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2] / "tests"))
