#!/usr/bin/env python3
"""Builds nav2_msgs, irobot_create_msgs, tf2_msgs and control_msgs into wheels, where no ROS installation brings them.

The wheels' paths go to standard output, one a line; progress goes to standard error.
"""

import argparse
import logging
import os
import shutil
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from interface_wheels.cache import cache_root, cached_wheels, fill
from interface_wheels.environment import install, is_installed, ros_provides
from interface_wheels.errors import InterfaceError
from interface_wheels.sources import InterfacePackage, cache_key, read_packages
from interface_wheels.toolchain import make_toolchain, require_system_tools
from interface_wheels.wheel import pack_wheel

log = logging.getLogger("interfaces")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns its exit status."""
    options = parse(arguments)
    logging.basicConfig(format="interfaces %(relativeCreated)6d ms  %(message)s", level=logging.INFO, stream=sys.stderr)
    packages = read_packages()
    try:
        if ros_provides(packages):
            log.info("nothing to build: the sourced ROS installation has %s", _names(packages))
            return 0
        wheels = wheels_for(packages, options.jobs)
        if options.install:
            install_missing(packages, wheels)
    except InterfaceError as error:
        log.error("%s", error)  # noqa: TRY400 - the sentence says what to do; a traceback would hide it
        return 1
    if options.output is not None:
        options.output.mkdir(parents=True, exist_ok=True)
        wheels = tuple(Path(shutil.copy2(wheel, options.output)) for wheel in wheels)
    sys.stdout.writelines(f"{wheel}\n" for wheel in wheels)
    return 0


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """The command line's options."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--install", action="store_true", help="also pip-install them for this interpreter")
    parser.add_argument("--output", type=Path, metavar="DIR", help="also copy the wheels to DIR")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="parallel jobs (%(default)s)")
    return parser.parse_args(arguments)


def wheels_for(packages: Sequence[InterfacePackage], jobs: int) -> tuple[Path, ...]:
    """The wheels of `packages`, from the cache or built now."""
    root, key = cache_root(), cache_key()
    wheels = cached_wheels(root, key)
    if wheels:
        log.info("found in the cache: %s", root / key)
        return wheels
    require_system_tools()
    log.info("building %s into %s", _names(packages), root / key)
    return fill(root, key, lambda work_dir: build_wheels(packages, key, jobs, work_dir))


def build_wheels(packages: Sequence[InterfacePackage], key: str, jobs: int, work_dir: Path) -> Path:
    """Build every package side by side in `work_dir`; returns the folder with the wheels."""
    log.info("installing the code generators, CMake and Ninja (about 350 MB while it builds)")
    toolchain = make_toolchain(work_dir / "toolchain", work_dir / "toolchain.log")
    output = work_dir / "wheels"
    output.mkdir()

    def build_one(package: InterfacePackage) -> None:
        log.info("%s: generating and compiling", package.name)
        place = work_dir / package.name
        place.mkdir()
        installed = toolchain.build(package, place, jobs, place / "build.log")
        runtime = [f"ros-{name.replace('_', '-')}" for name in (*package.depends, "rosidl_default_runtime")]
        requires = [f"{name}~={toolchain.version_of(name)}" for name in runtime]
        wheel = pack_wheel(installed, package, package.wheel_version(key), requires, output)
        log.info("%s: packed, %d KiB", package.name, wheel.stat().st_size // 1024)

    with ThreadPoolExecutor(max_workers=max(1, jobs)) as pool:
        list(pool.map(build_one, packages))
    return output


def install_missing(packages: Sequence[InterfacePackage], wheels: Sequence[Path]) -> None:
    """Install `wheels` unless exactly these are installed already."""
    key = cache_key()
    if all(is_installed(package, package.wheel_version(key)) for package in packages):
        log.info("installed already")
        return
    log.info("installing into %s", sys.prefix)
    install(wheels, cache_root() / "install.log")
    log.info("installed")


def _names(packages: Sequence[InterfacePackage]) -> str:
    return ", ".join(package.name for package in packages)


if __name__ == "__main__":
    raise SystemExit(main())
