"""What the processes of the mesh hold: memory and handles, looked at again and again."""

import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Final

import psutil

from demo.stack import Stack

TRACEBACK: Final = re.compile(r"^(?:\S*(?:Error|Exception)\b.*|Traceback .*)$", re.MULTILINE)


@dataclass(frozen=True)
class Holding:
    pid: int
    rss_mib: float
    handles: int
    threads: int


def holdings(stack: Stack) -> dict[str, Holding]:
    """Of every process that runs."""
    found = dict[str, Holding]()
    for name in ("redis", "sim", *stack.calls):
        if pid := stack.pid(name):
            process = psutil.Process(pid)
            rss_mib = round(process.memory_info().rss / 2**20, 1)
            found[name] = Holding(pid, rss_mib, process.num_fds(), process.num_threads())
    return found


def grown(before: Mapping[str, Holding], after: Mapping[str, Holding]) -> dict[str, dict[str, Any]]:
    """Of each process before and after."""
    return {name: {"before": asdict(before[name]), "after": asdict(after[name])} for name in before if name in after}


def complaints(stack: Stack) -> dict[str, list[str]]:
    """Tracebacks in each service's log: their last lines."""
    told = dict[str, list[str]]()
    for name in stack.calls:
        text = "".join(file.read_text(errors="replace") for file in sorted(stack.logs.glob(f"{name}.log*")))
        if "Traceback" in text or '"exception"' in text:
            told[name] = sorted(set(TRACEBACK.findall(text)))[:20] or ["a traceback"]
    return told
