#!/usr/bin/env python3
"""Makes the development environment: checks system libraries, fills `.venv`, builds the ROS interface wheels.

Needs only the standard library. Does nothing where nothing changed since the last time.
"""

import argparse
import ctypes.util
import hashlib
import importlib.util
import shutil
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
VENV = ROOT / ".venv"
PYTHON = VENV / "bin" / "python"
STAMP = VENV / "atom-setup.sha256"
PROJECTS = (
    "packages/contracts",
    "packages/geometry",
    "packages/vocabulary",
    "packages/mesh",
    "packages/cli",
    "services/robot_bridge[ros-wheels]",
    "services/inference[openvino,onnx]",
    "services/memory",
    "services/coordinator",
    "services/ui",
    "sim[ros-wheels]",
    "demo",
)
PYTHON_MIN = (3, 11)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--force", action="store_true", help="install again even if nothing changed")
    parser.add_argument("--tests", action="store_true", help="also check for what only the tests need")
    arguments = parser.parse_args()
    check_system(for_tests=arguments.tests)
    fingerprint = digest()
    if not arguments.force and STAMP.is_file() and STAMP.read_text() == fingerprint:
        return
    started = time.monotonic()
    if not PYTHON.exists():
        say(f"making {VENV.name} with {sys.executable}")
        run(sys.executable, "-m", "venv", str(VENV))
    say("installing Python packages (about 2 minutes the first time)")
    editable = [argument for project in PROJECTS for argument in ("-e", str(ROOT / project))]
    pip("install", "-q", "-c", str(ROOT / "constraints.txt"), "-r", str(ROOT / "requirements-dev.txt"), *editable)
    say("building the ROS 2 interface packages (about a minute the first time, then cached)")
    run(str(PYTHON), str(ROOT / "services/robot_bridge/interfaces/build.py"), "--install")
    STAMP.write_text(fingerprint)
    say(f"set up in {time.monotonic() - started:.0f} s")


def check_system(*, for_tests: bool) -> None:
    """Ends with the command that installs what is missing."""
    problems: list[str] = []
    packages: list[str] = []
    if sys.version_info < PYTHON_MIN:
        problems.append(f"Python {sys.version_info.major}.{sys.version_info.minor} is too old: 3.11 or newer is needed")
    if importlib.util.find_spec("ensurepip") is None:
        problems.append("Python's venv module is incomplete")
        packages.append("python3-venv")
    if shutil.which("gcc") is None or shutil.which("g++") is None:
        problems.append("no C and C++ compiler (for the ROS interface packages)")
        packages.append("build-essential")
    if not list(Path(include_folder()).glob("Python.h")):
        problems.append("no Python headers (for the ROS interface packages)")
        packages.append("python3-dev")
    if ctypes.util.find_library("EGL") is None:
        problems.append("no libEGL (the simulator renders with it)")
        packages += ["libegl1", "libgl1-mesa-dri"]
    if ctypes.util.find_library("OpenGL") is None:
        problems.append("no libOpenGL (the simulator renders with it)")
        packages.append("libopengl0")
    if for_tests and shutil.which("chromium") is None:
        problems.append("no Chromium (the tests of the page drive a real browser)")
        packages.append("chromium")
    if problems:
        lines = "\n".join(f"  - {problem}" for problem in problems)
        command = f"apt-get install -y --no-install-recommends {' '.join(packages)}"
        install = f"\nInstall with:\n  {command}" if packages else ""
        sys.exit(f"This machine lacks something ATOM needs:\n{lines}{install}")


def include_folder() -> str:
    import sysconfig

    return sysconfig.get_path("include")


def digest() -> str:
    """Of everything that decides what gets installed."""
    files = [ROOT / "constraints.txt", ROOT / "requirements-dev.txt", Path(__file__)]
    files += [ROOT / project.partition("[")[0] / "pyproject.toml" for project in PROJECTS]
    files += sorted((ROOT / "services/robot_bridge/interfaces").rglob("*.*"))
    found = hashlib.sha256(sys.version.encode())
    for file in files:
        if file.is_file() and "__pycache__" not in file.parts:
            found.update(file.read_bytes())
    return found.hexdigest()


def pip(*arguments: str) -> None:
    run(str(PYTHON), "-m", "pip", "--disable-pip-version-check", *arguments)


def run(*command: str) -> None:
    done = subprocess.run(command, check=False)
    if done.returncode != 0:
        sys.exit(f"setup failed at: {' '.join(command[:6])} ... (exit {done.returncode})")


def say(text: str) -> None:
    print(f"[setup] {text}", flush=True)  # noqa: T201 - a command-line tool


if __name__ == "__main__":
    main()
