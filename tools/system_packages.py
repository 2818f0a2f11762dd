"""What ATOM needs of the operating system, what of it is missing here, and the command that brings it."""

import ctypes.util
import importlib.util
import os
import shutil
import ssl
import subprocess
import sys
import sysconfig
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

NO_INSTALL = "ATOM_NO_INSTALL"
CHROMIUM_NAMES = ("chromium", "chromium-browser", "google-chrome")


@dataclass(frozen=True)
class Need:
    """A part of the system: how to see that it is there, and Debian's packages that bring it."""

    problem: str
    packages: tuple[str, ...]
    is_there: Callable[[], bool]
    for_tests_only: bool = False


def missing(*, for_tests: bool) -> list[Need]:
    """Every need that this machine does not meet, in the order of `NEEDS`."""
    return [need for need in NEEDS if (for_tests or not need.for_tests_only) and not need.is_there()]


def install_command(needs: list[Need], *, is_root: bool) -> list[str]:
    """The apt command that brings what `needs` name."""
    packages = [package for need in needs for package in need.packages]
    install = ["apt-get", "install", "-y", "--no-install-recommends", *packages]
    return install if is_root else ["sudo", *install]


def may_install(environment: Mapping[str, str], *, is_root: bool, has_apt: bool, has_sudo: bool) -> bool:
    """True where packages can be installed without a question: root or password-less sudo, on Debian or Ubuntu."""
    return has_apt and (is_root or has_sudo) and environment.get(NO_INSTALL, "") in {"", "0"}


def bring(needs: list[Need], say: Callable[[str], None]) -> list[Need]:
    """Installs what is missing where this machine lets us; returns what is missing still."""
    is_root = os.geteuid() == 0
    has_sudo = not is_root and _command("sudo") and _succeeds("sudo", "-n", "true")
    if not may_install(os.environ, is_root=is_root, has_apt=_command("apt-get"), has_sudo=has_sudo):
        return needs
    command = install_command(needs, is_root=is_root)
    say(f"this machine lacks: {'; '.join(need.problem for need in needs)}")
    say(f"installing it ({NO_INSTALL}=1 refuses): {' '.join(command)}")
    prefix = command[: command.index("apt-get")]
    quiet = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    for step in ([*prefix, "apt-get", "-qq", "update"], command):
        subprocess.run(step, env=quiet, stdout=subprocess.DEVNULL, check=False)
    return [need for need in needs if not need.is_there()]


def explain(needs: list[Need]) -> str:
    """What is missing, and the command that brings it, for a person."""
    lines = "\n".join(f"  - {need.problem}" for need in needs)
    command = " ".join(install_command(needs, is_root=os.geteuid() == 0))
    return f"This machine lacks something ATOM needs:\n{lines}\nInstall with:\n  {command}"


def chromium() -> str | None:
    """The browser that the tests drive: `ATOM_CHROMIUM`, else the system's, else the one Playwright has fetched."""
    if named := os.environ.get("ATOM_CHROMIUM"):
        return named if Path(named).is_file() else None
    if found := next(filter(None, map(shutil.which, CHROMIUM_NAMES)), None):
        return found
    cache = Path(os.environ.get("PLAYWRIGHT_BROWSERS_PATH") or Path.home() / ".cache" / "ms-playwright")
    return next((str(path) for path in sorted(cache.glob("chromium-*/chrome-linux*/chrome"))), None)


def mosquitto() -> str | None:
    """The broker that the tests start for themselves; Debian puts it where daemons are."""
    return shutil.which("mosquitto") or shutil.which("mosquitto", path="/usr/sbin")


def _module(name: str) -> bool:
    return importlib.util.find_spec(name) is not None


def _command(name: str) -> bool:
    return shutil.which(name) is not None


def _headers() -> bool:
    return (Path(sysconfig.get_path("include")) / "Python.h").is_file()


def _library(name: str) -> bool:
    """Without the linker's tools, `find_library` sees nothing: the folders are looked through then."""
    if ctypes.util.find_library(name) is not None:
        return True
    folders = ("/usr/lib", "/usr/lib64", f"/usr/lib/{sys.implementation._multiarch}")  # type: ignore[attr-defined]
    return any(list(Path(folder).glob(f"lib{name}.so*")) for folder in folders)


def _certificates() -> bool:
    paths = ssl.get_default_verify_paths()
    return any(path and Path(path).exists() for path in (paths.cafile, "/etc/ssl/certs/ca-certificates.crt"))


def _succeeds(*command: str) -> bool:
    return subprocess.run(command, capture_output=True, check=False).returncode == 0


NEEDS = (
    Need("Python's venv module is incomplete", ("python3-venv",), lambda: _module("ensurepip")),
    Need(
        "no C and C++ compiler (for the ROS interface packages)",
        ("build-essential",),
        lambda: _command("gcc") and _command("g++"),
    ),
    Need("no Python headers (for the ROS interface packages)", ("python3-dev",), _headers),
    Need("no libEGL (the simulator renders with it)", ("libegl1", "libgl1-mesa-dri"), lambda: _library("EGL")),
    Need("no libOpenGL (the simulator renders with it)", ("libopengl0",), lambda: _library("OpenGL")),
    Need("no root certificates", ("ca-certificates",), _certificates),
    Need("no make", ("make",), lambda: _command("make")),
    Need(
        "no Chromium (the tests of the page drive a real browser; ATOM_CHROMIUM=/path/to/one uses another)",
        ("chromium",),
        lambda: chromium() is not None,
        for_tests_only=True,
    ),
    Need(
        "no espeak-ng (the tests of speech let it speak to Whisper)",
        ("espeak-ng",),
        lambda: _command("espeak-ng"),
        for_tests_only=True,
    ),
    Need(
        "no mosquitto (the tests of the way to Home Assistant need a real broker)",
        ("mosquitto",),
        lambda: mosquitto() is not None,
        for_tests_only=True,
    ),
)
