"""Where a benchmark's figures go, and how it draws without a display."""

import json
import logging
from pathlib import Path
from typing import Any

import structlog


def save(path: Path, figures: object) -> None:
    """As JSON; the folder is made."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")


def pyplot() -> Any:
    import matplotlib as library

    library.use("Agg")
    from matplotlib import pyplot as plt

    return plt


def quiet() -> None:
    """The services' logs are left out."""
    structlog.configure(wrapper_class=structlog.make_filtering_bound_logger(logging.CRITICAL))
