"""Makes the interface build importable: it is a script with a package beside it, not an installed distribution."""

import sys
from pathlib import Path

INTERFACES_DIR = Path(__file__).resolve().parents[3] / "services" / "robot_bridge" / "interfaces"

sys.path.insert(0, str(INTERFACES_DIR))
