"""A training run on disk: everything it needs to go on where it was broken off, on a machine that others use too."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch


@dataclass(frozen=True)
class Checkpoint:
    """The state of `parts` (anything with a `state_dict`) in one file, which is gone once the run is done."""

    path: Path
    parts: Mapping[str, Any]

    def load(self) -> int:
        """Restore the parts; returns the step to go on with, 0 where no run was broken off."""
        if not self.path.exists():
            return 0
        saved = torch.load(self.path, map_location="cpu", weights_only=True)
        for name, part in self.parts.items():
            part.load_state_dict(saved[name])
        return int(saved["step"])

    def save(self, step: int) -> None:
        """Write all parts; `step` is the next one to do."""
        partial = self.path.with_suffix(".partial")
        torch.save({"step": step} | {name: part.state_dict() for name, part in self.parts.items()}, partial)
        partial.replace(self.path)

    def done(self) -> None:
        """Nothing is left to go on with."""
        self.path.unlink(missing_ok=True)
