"""Which packages there are, and the key under which their wheels are cached."""

import hashlib
import re
import sys
import sysconfig
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

HOME = Path(__file__).resolve().parent.parent
PACKAGES_DIR = HOME / "packages"
REQUIREMENTS = HOME / "requirements-build.txt"
OPTIONAL = frozenset({"control_msgs"})
"""What only a robot with an arm needs: a sourced ROS may do without."""
BUILD_STEPS = (HOME / "interface_wheels" / "toolchain.py", HOME / "interface_wheels" / "wheel.py")


@dataclass(frozen=True)
class InterfacePackage:
    """One ROS interface package as its package.xml describes it."""

    name: str
    version: str
    depends: tuple[str, ...]
    directory: Path

    @property
    def distribution(self) -> str:
        """The wheel's name; its own prefix keeps it apart from a registry's package of the same interfaces."""
        return f"atom_{self.name}"

    def wheel_version(self, key: str) -> str:
        """The package's version and the cache key, so that every rebuild is a new version to pip."""
        return f"{self.version}+g{key}"


def read_packages(packages_dir: Path = PACKAGES_DIR) -> tuple[InterfacePackage, ...]:
    """Every package below `packages_dir`, largest first, so that a parallel build ends sooner."""
    found = [_read_package(manifest) for manifest in packages_dir.glob("*/package.xml")]
    return tuple(sorted(found, key=lambda package: (-_interface_count(package), package.name)))


def cache_key(
    packages_dir: Path = PACKAGES_DIR, requirements: Path = REQUIREMENTS, python_tag: str | None = None
) -> str:
    """A hex digest that changes with any source file, pinned requirement, build step, Python version or platform."""
    digest = hashlib.sha256()
    digest.update((python_tag or f"{sys.implementation.cache_tag} {sysconfig.get_platform()}").encode())
    for root, files in (
        (packages_dir, packages_dir.rglob("*")),
        (requirements.parent, [requirements]),
        (HOME, BUILD_STEPS),
    ):
        for path in _plain_files(files):
            content = path.read_bytes()
            digest.update(f"\0{path.relative_to(root).as_posix()}\0{len(content)}\0".encode())
            digest.update(content)
    return digest.hexdigest()[:16]


def _plain_files(paths: Iterable[Path]) -> list[Path]:
    return sorted(path for path in paths if path.is_file() and "__pycache__" not in path.parts)


def _read_package(manifest: Path) -> InterfacePackage:
    text = manifest.read_text()
    version = re.search(r"<version>(.+?)</version>", text)
    if version is None:
        raise ValueError(f"{manifest} names no version")
    depends = tuple(re.findall(r"<depend>(.+?)</depend>", text))
    return InterfacePackage(manifest.parent.name, version[1], depends, manifest.parent)


def _interface_count(package: InterfacePackage) -> int:
    return sum(1 for kind in ("msg", "srv", "action") for _ in package.directory.glob(f"{kind}/*"))
