"""What the running interpreter already has, and putting wheels into it."""

import importlib.metadata
import importlib.util
import os
import sys
import sysconfig
from collections.abc import Sequence
from pathlib import Path

from interface_wheels.commands import run
from interface_wheels.errors import MissingToolError, PartialRosError
from interface_wheels.sources import OPTIONAL, InterfacePackage


def ros_provides(packages: Sequence[InterfacePackage]) -> bool:
    """Whether a sourced ROS installation brings all of `packages` but those that not every robot needs.

    Raises PartialRosError where one is sourced that lacks some of them.
    """
    needed = [package.name for package in packages if package.name not in OPTIONAL]
    missing = [name for name in needed if not _is_outside_this_environment(name)]
    if not missing:
        return True
    if _is_outside_this_environment("rclpy"):
        raise PartialRosError(missing, os.environ.get("ROS_DISTRO", "jazzy"))
    return False


def is_installed(package: InterfacePackage, version: str) -> bool:
    """Whether exactly this build of `package` is installed for the running interpreter."""
    try:
        return importlib.metadata.version(package.distribution) == version
    except importlib.metadata.PackageNotFoundError:
        return False


def install_command(python: Path) -> list[str]:
    """Installs into the environment of `python`: uv's command where the variable UV names one, else pip's.

    Raises MissingToolError without either.
    """
    if uv := os.environ.get("UV"):
        return [uv, "pip", "install", "--python", str(python)]
    if importlib.util.find_spec("pip") is None:
        raise MissingToolError([f"pip for {sys.executable}"], ["python3-pip"])
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--no-input"]
    return [*pip, "--python", str(python), "install", "--no-compile"]


def install(wheels: Sequence[Path], log: Path) -> None:
    """Install `wheels` for the running interpreter; what they depend on is fetched only where it is missing."""
    run("installing the wheels", [*install_command(Path(sys.executable)), *map(str, wheels)], log)


def _is_outside_this_environment(module: str) -> bool:
    spec = importlib.util.find_spec(module)
    if spec is None or spec.origin is None:
        return False
    own = {Path(sysconfig.get_path(name)).resolve() for name in ("purelib", "platlib")}
    return own.isdisjoint(Path(spec.origin).resolve().parents)
