"""Writes the table of metrics into docs/observing.md: `.venv/bin/python tools/metrics_table.py`. A test compares."""

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).parents[1]
PAGE: Final = ROOT / "docs/observing.md"
BEGIN, END = "<!-- metrics -->\n", "<!-- /metrics -->\n"
KINDS: Final = {"Counter": "counter", "Gauge": "gauge", "Histogram": "histogram", "Enum": "gauge"}
FOLDERS: Final = ("packages/mesh", "services/coordinator", "services/inference", "services/memory",
                  "services/robot_bridge", "services/speech", "services/ui")  # fmt: skip


@dataclass(frozen=True)
class Metric:
    """One as the code declares it. A counter's and a histogram's samples end otherwise than its name: see `samples`."""

    name: str
    kind: str
    labels: tuple[str, ...]
    text: str
    told_by: str
    in_adapter: bool

    @property
    def samples(self) -> set[str]:
        if self.kind == "histogram":
            return {f"{self.name}_{end}" for end in ("bucket", "sum", "count")}
        return {self.name}


def metrics() -> list[Metric]:
    """All that are declared in the services and in the mesh, by name."""
    found = [
        metric for folder in FOLDERS for file in (ROOT / folder / "src").rglob("*.py") for metric in _in(file, folder)
    ]
    return sorted(found, key=lambda one: (one.told_by != "every service", one.told_by, one.name))


def _in(file: Path, folder: str) -> Iterator[Metric]:
    told_by = "every service" if folder == "packages/mesh" else folder.rpartition("/")[2]
    in_adapter = "adapters" in file.parts
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in KINDS:
            said = [one.value for one in node.args if isinstance(one, ast.Constant)]
            lists = [one for one in node.args if isinstance(one, ast.List)]
            if len(said) == 2:
                labels = [str(one.value) for one in (lists[0].elts if lists else []) if isinstance(one, ast.Constant)]
                labels += [said[0]] if node.func.id == "Enum" else []
                yield Metric(str(said[0]), KINDS[node.func.id], tuple(labels), str(said[1]), told_by, in_adapter)


def table() -> str:
    rows = [
        f"| {one.told_by} | `{one.name}` | {one.kind} | {' '.join(f'`{label}`' for label in one.labels)} | {one.text} |"
        for one in metrics()
    ]
    return "\n".join(["| told by | metric | kind | labels | |", "|---|---|---|---|---|", *rows]) + "\n"


def page() -> str:
    """The page with the table as the code is now."""
    head, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    return head + BEGIN + table() + END + rest.partition(END)[2]


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
