"""The page lies below any path: none of its addresses begins at the host's root, and only one place builds them."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from support.source import ROOT

UI = ROOT / "services/ui/src/ui"
SCRIPTS = sorted((UI / "assets").glob("*.js"))
FROM_THE_ROOT = re.compile(r"""["'`(=]/[A-Za-z_]""")
"""A string, template, url() or attribute that begins with a slash."""
SHOWN = sorted(path for part in ("panels", ".") for path in (UI / part).glob("*.py"))
OF_THE_SERVER = {("page.py", "/assets"), ("app.py", "/memory/import"), ("app.py", "/stop")}
"""Routes as the server itself names them."""


@pytest.mark.parametrize("path", [*SCRIPTS, *(UI / "assets").glob("*.css")], ids=lambda path: path.name)
def test_no_script_or_style_names_an_address_from_the_root(path: Path) -> None:
    lines = path.read_text(encoding="utf-8").splitlines()
    assert [line for line in lines if FROM_THE_ROOT.search(line.split("//")[0])] == []


@pytest.mark.parametrize("path", [path for path in SCRIPTS if path.name != "base.js"], ids=lambda path: path.name)
@pytest.mark.parametrize(
    "own", [r"\bfetch\(", r"location\.(host|origin|protocol|pathname)", r"new WebSocket\((?!socketUrl\()"]
)
def test_only_base_js_builds_addresses_and_asks_without_an_end(path: Path, own: str) -> None:
    assert re.findall(own, path.read_text(encoding="utf-8")) == []


def beginnings(path: Path) -> Iterator[str]:
    """How each text in a module begins; docstrings and later parts of a formatted text apart."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    parts = {part for node in ast.walk(tree) if isinstance(node, ast.JoinedStr) for part in node.values[1:]}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node not in parts:
            yield node.value


@pytest.mark.parametrize("path", SHOWN, ids=lambda path: path.name)
def test_nothing_the_page_is_made_of_names_an_address_from_the_root(path: Path) -> None:
    found = {(path.name, text) for text in beginnings(path) if re.match(r"/[A-Za-z_]", text)}
    assert found - OF_THE_SERVER == set()
    assert [text for text in beginnings(path) if re.search(r"(src|href|action)=[\"']?/|url\(/", text)] == []


def test_the_scan_has_something_to_look_at() -> None:
    assert {"base.js", "stop.js", "drive.js"} <= {path.name for path in SCRIPTS}
    assert {"page.py", "stop.py", "history_panel.py"} <= {path.name for path in SHOWN}
