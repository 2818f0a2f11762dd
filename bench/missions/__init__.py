"""Missions in-process: the real coordinator over a simulated home, without ROS, on a simulated clock.

The home, its map, its lines of sight and the judgement are `sim`'s. The robot moves kinematically (no physics), and
what the camera shows comes from ground truth, not from the network: `seeing.py` says with which errors.
"""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2] / "tests"))
