"""The parts of `bench.hostile`: what is sent, and what the mesh's processes hold meanwhile.

A running mesh is asked through `tests/support`, which is put on the path here.
"""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2] / "tests"))
