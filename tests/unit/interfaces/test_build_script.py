"""The script says what it does, and what is missing, before it does anything slow."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from interface_wheels.commands import clean_environment, run
from interface_wheels.errors import CommandFailedError
from interface_wheels.sources import HOME, read_packages

PACKAGE_NAMES = [package.name for package in read_packages()]


def run_script(tmp_path: Path, *arguments: str, **variables: str) -> "subprocess.CompletedProcess[str]":
    """The script in an environment with an empty cache; -S keeps what this interpreter has installed out of the way."""
    return subprocess.run(
        [sys.executable, "-S", str(HOME / "build.py"), *arguments],
        env=clean_environment({"ATOM_CACHE_DIR": str(tmp_path / "cache"), **variables}),
        capture_output=True,
        text=True,
        timeout=90,
        check=False,
    )


def make_modules(directory: Path, *names: str) -> Path:
    """Importable stand-ins, as a sourced ROS installation puts them on PYTHONPATH."""
    for name in names:
        (directory / name).mkdir(parents=True)
        (directory / name / "__init__.py").touch()
    return directory


def test_help_names_every_option(tmp_path: Path) -> None:
    done = run_script(tmp_path, "--help")
    assert done.returncode == 0
    assert all(option in done.stdout for option in ("--install", "--output", "--jobs"))


def test_nothing_is_built_where_a_sourced_ros_brings_the_packages(tmp_path: Path) -> None:
    ros = make_modules(tmp_path / "ros", "rclpy", *PACKAGE_NAMES)
    done = run_script(tmp_path, "--install", PYTHONPATH=str(ros))
    assert done.returncode == 0
    assert "nothing to build: the sourced ROS installation has" in done.stderr
    assert not (tmp_path / "cache").exists()


def test_a_sourced_ros_may_lack_what_only_an_arm_needs(tmp_path: Path) -> None:
    needed = [name for name in PACKAGE_NAMES if name != "control_msgs"]
    done = run_script(tmp_path, PYTHONPATH=str(make_modules(tmp_path / "ros", "rclpy", *needed)))
    assert done.returncode == 0
    assert "nothing to build" in done.stderr


def test_a_sourced_ros_that_lacks_a_package_is_completed_with_apt_and_not_mixed(tmp_path: Path) -> None:
    ros = make_modules(tmp_path / "ros", "rclpy", "nav2_msgs", "tf2_msgs")
    done = run_script(tmp_path, PYTHONPATH=str(ros), ROS_DISTRO="jazzy")
    assert done.returncode == 1
    assert "sudo apt-get install -y ros-jazzy-irobot-create-msgs" in done.stderr


def test_missing_compilers_are_named_with_the_command_that_brings_them(tmp_path: Path) -> None:
    done = run_script(tmp_path, CC="no-such-gcc", CXX="no-such-g++ -m64")
    assert done.returncode == 1
    assert "not found: no-such-gcc, no-such-g++" in done.stderr
    assert "sudo apt-get install -y gcc g++" in done.stderr


def test_wheels_in_the_cache_are_handed_out_and_copied_without_a_compiler(tmp_path: Path) -> None:
    root = tmp_path / "cache" / "interfaces"
    key = run_python("from interface_wheels.sources import cache_key; print(cache_key())")
    (root / key).mkdir(parents=True)
    (root / key / "some.whl").touch()
    done = run_script(tmp_path, "--output", str(tmp_path / "out"), CC="no-such-gcc")
    assert done.returncode == 0, done.stderr
    assert done.stdout == f"{tmp_path / 'out' / 'some.whl'}\n"
    assert (tmp_path / "out" / "some.whl").is_file()


def run_python(code: str) -> str:
    return subprocess.run(
        [sys.executable, "-S", "-c", code],
        env=clean_environment({"PYTHONPATH": str(HOME)}),
        capture_output=True,
        text=True,
        timeout=90,
        check=True,
    ).stdout.strip()


def test_what_ros_leaks_does_not_reach_child_processes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LD_LIBRARY_PATH", "somewhere")
    monkeypatch.setenv("_ROS_WHEELS_BOOTSTRAP_COMPLETE", "1")
    assert not {"LD_LIBRARY_PATH", "_ROS_WHEELS_BOOTSTRAP_COMPLETE"} & set(clean_environment())
    assert clean_environment()["PATH"] == os.environ["PATH"]


def test_a_failing_command_is_reported_with_the_end_of_what_it_said(tmp_path: Path) -> None:
    command = [sys.executable, "-S", "-c", "print('the reason'); raise SystemExit(3)"]
    with pytest.raises(CommandFailedError, match=r"compiling x \(exit 3\) failed:\nthe reason"):
        run("compiling x", command, tmp_path / "log")
