"""The page's words: English in the source, another language from one TOML file of English = "translation"."""

import ast
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

HERE: Final = Path(__file__).parent
_IN_SCRIPTS: Final = re.compile(r"""\bt\(\s*"((?:[^"\\]|\\.)*)\"""")
_catalogue: dict[str, str] = {}


def N_(text: str) -> str:  # noqa: N802 - gettext's word
    """Names a text that is looked up later, by `_`."""
    return text


def _(text: str, **values: Any) -> str:
    """The text in the language in use, with its {places} filled; English where there is no translation."""
    found = _catalogue.get(text, text)
    return found.format(**values) if values else found


def use(catalogue: Mapping[str, str]) -> None:
    """From now on; once a process, before the first page."""
    _catalogue.clear()
    _catalogue.update(catalogue)


def load(path: Path | None) -> dict[str, str]:
    """English to translation; empty (English) without a file. Raises `ValueError` naming what is not a text."""
    if path is None:
        return {}
    found = tomllib.loads(path.read_text(encoding="utf-8"))
    wrong = [key for key, value in found.items() if not isinstance(value, str)]
    if wrong:
        raise ValueError(f"{path}: not a text: {', '.join(wrong[:5])}")
    return found


def for_scripts() -> dict[str, str]:
    """What the scripts in the browser need of the language in use."""
    return {text: _(text) for text in sorted(_script_texts())}


def all_texts() -> tuple[str, ...]:
    """Every text a translation file may hold; `python -m ui.i18n` writes such a file."""
    found = _script_texts()
    for module in HERE.rglob("*.py"):
        for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in {"_", "N_"}:
                found |= {arg.value for arg in node.args[:1] if _is_text(arg) and isinstance(arg.value, str)}  # type: ignore[attr-defined]
    return tuple(sorted(found))


def _is_text(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def _script_texts() -> set[str]:
    scripts = (path.read_text(encoding="utf-8") for path in (HERE / "assets").glob("*.js"))
    return {match.replace('\\"', '"') for script in scripts for match in _IN_SCRIPTS.findall(script)}


def template() -> str:
    quoted = (text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") for text in all_texts())
    return "".join(f'"{text}" = "{text}"\n' for text in quoted)


if __name__ == "__main__":
    print(template(), end="")  # noqa: T201 - a command-line tool
