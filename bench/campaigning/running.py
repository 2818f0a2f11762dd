"""What a worker process does: plays one mission and writes its record. (A spawned one cannot import `__main__`.)"""

import json
import time
from pathlib import Path
from typing import Any

from bench.campaigning.episode import faulted
from bench.campaigning.play import played
from bench.search.running import loaded


def worked(seed: int, out: Path, until_s: float) -> dict[str, Any] | None:
    """In a process of its own; none where it is too late to begin."""
    if time.monotonic() > until_s:
        return None
    models, settings = loaded("sim")
    record = played(faulted(seed), models, settings, tours=out / "tours")
    partial = out / f"{seed:04d}.partial"
    partial.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    partial.replace(partial.with_suffix(".json"))
    return record
