"""How well commands are read: by the rules alone, and by whatever language model INFERENCE_* names, with its times."""

import argparse
import asyncio
import csv
import json
import random
import sys
import time
from collections import Counter
from collections.abc import Sequence
from contextlib import AsyncExitStack
from pathlib import Path
from typing import Any

from bench import people
from bench.results import save
from contracts.vision import ParsedTarget, ParseTaskRequest
from inference.language.providers import Providers
from inference.languages import Languages, open_languages
from inference.parsing import parser
from inference.parsing.task_parsing import Reader
from inference.settings import Settings
from mesh.clock import SystemClock

ROOT = Path(__file__).parents[1]
WARM_UP = "find the red cup"


def main() -> None:
    options = _options()
    rows = list(csv.DictReader(options.table.read_text(encoding="utf-8").splitlines()))
    if options.quick:
        rows = rows[::20]
    report: dict[str, Any] = {"commands": len(rows), "rules": _by_rules(rows), "people": asyncio.run(_of_people())}
    settings = Settings()
    if settings.ollama_url or settings.openai_url:
        sample = rows if not options.sample else random.Random(0).sample(rows, min(options.sample, len(rows)))
        report["model"] = asyncio.run(_by_model(settings, sample))
    save(options.out, report)
    sys.stdout.write(json.dumps(report, indent=2) + "\n")


def _by_rules(rows: Sequence[dict[str, str]]) -> dict[str, Any]:
    parser.parse(ParseTaskRequest(command=WARM_UP))
    right: Counter[str] = Counter()
    every: Counter[str] = Counter()
    took_ms: list[float] = []
    for row in rows:
        began_s = time.perf_counter()
        task = parser.parse(ParseTaskRequest(command=row["command"]))
        took_ms.append((time.perf_counter() - began_s) * 1000)
        for group in ("all", row["part"], f"{row['part']} {row['kind']}"):
            every[group] += 1
            right[group] += _is_right(task, row)
    scores = {group: round(right[group] / count, 4) for group, count in sorted(every.items())}
    return {"right": scores} | _times(took_ms)


async def _of_people() -> dict[str, Any]:
    """The sayings of tests/data/people.csv, read by the rules; the held-out half apart."""
    none = Providers.of((), retry_after_s=1.0, clock=SystemClock())
    reader = Reader(none, none, deadline_s=8.0)
    halves: dict[str, Any] = {}
    for half in ("tuned", "held_out"):
        some = people.rows(half)
        read = [(row, await reader.parse(ParseTaskRequest(command=row["text"]))) for row in some]
        halves[half] = people.report(read)
    return halves


async def _by_model(settings: Settings, rows: Sequence[dict[str, str]]) -> dict[str, Any]:
    """The service's own reader: the model first, checked, the rules behind it."""
    async with AsyncExitStack() as stack:
        languages = open_languages(settings, stack, SystemClock())
        warm_up = await _timed(languages, WARM_UP)
        told = [(await _timed(languages, row["command"]), row) for row in rows]
    names = Counter(task.parser for (task, _), _ in told)
    by_model = [(task, row) for (task, _), row in told if task.parser != parser.PARSER]
    classes = sum(task.yolo_class == row["yolo_class"] for task, row in by_model)
    whole = sum(_is_right(task, row) for task, row in by_model)
    return {
        "names": [one.name for one in languages.reader.infos()],
        "commands": len(rows),
        "answered_by": dict(names),
        "class_right_of_its_own": round(classes / max(1, len(by_model)), 4),
        "right_of_its_own": round(whole / max(1, len(by_model)), 4),
        "right_together": round(sum(_is_right(task, row) for (task, _), row in told) / len(rows), 4),
        "first_ms": round(warm_up[1], 1),
        "troubles": dict(Counter(task.notes for (task, _), _ in told if task.notes).most_common(8)),
    } | _times([ms for (_, ms), _ in told])


async def _timed(languages: Languages, command: str) -> tuple[ParsedTarget, float]:
    """The first thing that is known, else the first."""
    began_s = time.perf_counter()
    task = await languages.reader.parse(ParseTaskRequest(command=command))
    took_ms = (time.perf_counter() - began_s) * 1000
    nothing = ParsedTarget(said=command, yolo_class="none", parser=parser.PARSER, notes=task.notes)
    return next(iter((*people.known(task), *task.targets, nothing))), took_ms


def _is_right(task: ParsedTarget, row: dict[str, str]) -> bool:
    return (task.yolo_class, task.description) == (row["yolo_class"], row["description"])


def _times(took_ms: Sequence[float]) -> dict[str, float]:
    ranked = sorted(took_ms)
    at = {"p50_ms": 0.50, "p99_ms": 0.99}
    return {name: round(ranked[min(len(ranked) - 1, int(share * len(ranked)))], 3) for name, share in at.items()}


def _options() -> argparse.Namespace:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--table", type=Path, default=ROOT / "tests" / "data" / "commands.csv")
    options.add_argument("--out", type=Path, default=ROOT / "out" / "bench" / "parser.json")
    options.add_argument("--sample", type=int, default=0, help="commands the model is asked, 0 = all of the table")
    options.add_argument("--quick", action="store_true", help="every twentieth command")
    return options.parse_args()


if __name__ == "__main__":
    main()
