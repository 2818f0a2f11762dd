"""The repository's own Python source as data: which module imports what, read without running any of it."""

import ast
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SERVICES = ("coordinator", "inference", "memory", "robot_bridge", "speech", "ui")
SOURCES = {
    "contracts": ROOT / "packages/contracts/src/contracts",
    "geometry": ROOT / "packages/geometry/src/geometry",
    "grasping": ROOT / "packages/grasping/src/grasping",
    "vocabulary": ROOT / "packages/vocabulary/src/vocabulary",
    "mesh": ROOT / "packages/mesh/src/mesh",
    "clients": ROOT / "packages/clients/src/clients",
    "store": ROOT / "packages/store/src/store",
    "atom_cli": ROOT / "packages/cli/src/atom_cli",
    "ear": ROOT / "packages/ear/src/ear",
    "home_assistant": ROOT / "packages/home_assistant/src/home_assistant",
    "sim": ROOT / "sim/src/sim",
    "demo": ROOT / "demo/src/demo",
    **{name: ROOT / "services" / name / "src" / name for name in SERVICES},
}
OURS = frozenset(SOURCES)


@dataclass(frozen=True)
class Module:
    """One file; `imports` holds the dotted names it imports anywhere in it, also inside functions."""

    name: str
    path: Path
    tree: ast.Module
    imports: frozenset[str]

    @property
    def roots(self) -> frozenset[str]:
        """Top-level packages imported."""
        return frozenset(name.partition(".")[0] for name in self.imports)

    @property
    def third_party(self) -> frozenset[str]:
        return frozenset(root for root in self.roots if root not in sys.stdlib_module_names and root not in OURS)


@cache
def modules(package: str) -> tuple[Module, ...]:
    """Every module of one of `SOURCES`, by name."""
    folder = SOURCES[package]
    return tuple(sorted((_read(package, folder, path) for path in folder.rglob("*.py")), key=lambda one: one.name))


def all_modules() -> Iterator[Module]:
    for package in SOURCES:
        yield from modules(package)


def within(name: str, packages: frozenset[str] | tuple[str, ...]) -> bool:
    """Is a dotted name one of these packages, or inside one?"""
    return any(name == package or name.startswith(f"{package}.") for package in packages)


def imports_of(tree: ast.AST, module: str, *, is_package: bool = False) -> frozenset[str]:
    """Dotted names imported by `import`, by `from` (relative ones resolved) and by `import_module("...")`.

    `from a import b` gives `a.b` too, since `b` may be a module.
    """
    found: set[str] = set()
    for node in ast.walk(tree):
        match node:
            case ast.Import(names=names):
                found |= {alias.name for alias in names}
            case ast.ImportFrom(module=source, names=names, level=level):
                base = _resolved(module, source, level, is_package=is_package)
                found |= {base, *(f"{base}.{alias.name}" for alias in names)}
            case ast.Call(func=ast.Attribute(attr="import_module") | ast.Name(id="import_module" | "__import__")):
                found |= {
                    one.value for one in node.args[:1] if isinstance(one, ast.Constant) and isinstance(one.value, str)
                }
            case _:
                pass
    return frozenset(found)


def _resolved(module: str, source: str | None, level: int, *, is_package: bool) -> str:
    if level == 0:
        return source or ""
    parts = module.split(".")
    kept = parts[: len(parts) - level + (1 if is_package else 0)]
    return ".".join([*kept, *([source] if source else [])])


def _read(package: str, folder: Path, path: Path) -> Module:
    inside = path.relative_to(folder).with_suffix("")
    is_package = path.name == "__init__.py"
    parts = inside.parts[:-1] if is_package else inside.parts
    name = ".".join((package, *parts))
    tree = ast.parse(path.read_text(encoding="utf-8"), filename=str(path))
    return Module(name, path, tree, imports_of(tree, name, is_package=is_package))
