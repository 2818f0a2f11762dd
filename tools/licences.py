"""Writes docs/licences.md's tables from the installed distributions: `python tools/licences.py`. A test compares."""

import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib.metadata import Distribution, distributions
from pathlib import Path
from typing import Final

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT: Final = Path(__file__).parents[1]
PAGE: Final = ROOT / "docs/licences.md"
BEGIN, END = "<!-- licences -->\n", "<!-- /licences -->\n"
TABLE: Final = tomllib.loads((ROOT / "tools/licences.toml").read_text(encoding="utf-8"))
IMAGES: Final = {
    "robot_bridge": "atom-robot-bridge[ros-wheels,foxglove]",
    "inference": "atom-inference[openvino]",
    "memory": "atom-memory",
    "coordinator": "atom-coordinator[arm]",
    "ui": "atom-ui",
    "speech": "atom-speech",
    "keys": "atom-cli",
    "ear": "atom-ear[device]",
    "sim": "atom-sim[ros-wheels,arm]",
    "demo": "atom-demo",
}
"""Each image's own package with the extras that its Dockerfile installs, or is told to; the demo is no image."""
OURS: Final = {
    about["name"]: about
    for pattern in ("packages/*/pyproject.toml", "services/*/pyproject.toml", "*/pyproject.toml")
    for file in ROOT.glob(pattern)
    if (about := tomllib.loads(file.read_text(encoding="utf-8"))["project"])
}
HAVE: Final = {canonicalize_name(one.name): one for one in distributions()}


@dataclass(frozen=True)
class Entry:
    """A distribution that somebody gets who runs ATOM."""

    name: str
    version: str
    licence: str
    why: str
    images: tuple[str, ...]
    asked_for: bool

    @property
    def accepted(self) -> bool:
        parts = re.split(r" AND | OR |; ", self.licence.replace("(", "").replace(")", ""))
        return self.licence == TABLE["accepted_for"].get(self.name) or all(one in TABLE["accepted"] for one in parts)


@cache
def entries() -> list[Entry]:
    """All of other people's, by name."""
    asked_by: dict[str, str] = {}
    used_in: dict[str, list[str]] = {}
    for image, package in IMAGES.items():
        for name, by in needed(package).items():
            used_in.setdefault(name, []).append(image)
            if asked_by.setdefault(name, by) != by and by.startswith("atom-"):
                asked_by[name] = by
    return [_entry(name, asked_by[name], used_in[name]) for name in sorted(used_in) if not name.startswith("atom-")]


def needed(package: str) -> dict[str, str]:
    """What is installed with a package, each with who asks for it; our own packages' wishes come first."""
    found: dict[str, str] = {}
    waiting = [(Requirement(package), "")]
    done: set[tuple[str, frozenset[str]]] = set()
    while waiting:
        waiting.sort(key=lambda one: not one[1].startswith("atom-"))
        wanted, by = waiting.pop(0)
        name = canonicalize_name(wanted.name)
        if name not in HAVE or (name, frozenset(wanted.extras)) in done:
            continue
        done.add((name, frozenset(wanted.extras)))
        found.setdefault(name, by)
        asked = _asked(name, wanted.extras)
        extras = [{"extra": extra} for extra in ("", *wanted.extras)]
        waiting += [(one, name) for one in asked if not one.marker or any(map(one.marker.evaluate, extras))]
    return found


def licence_of(distribution: Distribution) -> str:
    """As it says itself, in the names of SPDX where another spelling is known."""
    name = canonicalize_name(distribution.name)
    said = TABLE["licence"].get(name) or next(_said(distribution), "not said")
    return "; ".join(dict.fromkeys(TABLE["same"].get(part, part) for part in said.split("; ")))


def page() -> str:
    """The page with the table as the distributions have it now."""
    before, rest = PAGE.read_text(encoding="utf-8").split(BEGIN)
    lines = ["| distribution | version | licence | why it is there | in |", "|---|---|---|---|---|"]
    for one in entries():
        where = "all" if len(one.images) == len(IMAGES) else " ".join(one.images)
        lines.append(f"| {one.name} | {one.version} | {one.licence} | {one.why} | {where} |")
    return before + BEGIN + "\n".join(lines) + "\n" + END + rest.split(END)[1]


def _asked(name: str, extras: set[str]) -> list[Requirement]:
    """Of our own packages as pyproject.toml says it now: an editable install remembers what it said then."""
    if about := OURS.get(name):
        more = [one for extra in extras for one in about["optional-dependencies"][extra]]
        return [Requirement(one) for one in [*about["dependencies"], *more]]
    return [Requirement(one) for one in HAVE[name].requires or []]


def _entry(name: str, by: str, images: list[str]) -> Entry:
    ours = by.startswith("atom-")
    why = TABLE["why"].get(name, "") if ours else f"for {by}"
    found = HAVE[canonicalize_name(name)]
    return Entry(name, found.version, licence_of(found), why, tuple(images), ours)


def _said(distribution: Distribution) -> Iterator[str]:
    about = distribution.metadata
    if said := about.get("License-Expression"):
        yield said
    classified = [one.rpartition(" :: ")[2] for one in about.get_all("Classifier", []) if one.startswith("License ::")]
    if classified:
        yield "; ".join(classified)
    if said := about.get("License"):
        yield said.splitlines()[0]
    for file in distribution.files or []:
        if file.name == "package.xml":
            said = re.findall(r"<license[^>]*>([^<]+)<", Path(str(file.locate())).read_text(encoding="utf-8"))
            yield "; ".join(dict.fromkeys(said))
    if distribution.name.startswith("ros-"):
        yield "Apache-2.0"  # the wheels of ROS's core that carry no package.xml: names for others, or of ROS's own code


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
