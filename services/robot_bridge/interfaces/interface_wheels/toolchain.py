"""A throwaway virtual environment with ROS's code generators, CMake and Ninja in it."""

import importlib.metadata
import os
import re
import shutil
import sysconfig
import venv
from dataclasses import dataclass
from pathlib import Path

from interface_wheels.commands import clean_environment, run
from interface_wheels.environment import install_command
from interface_wheels.errors import MissingToolError
from interface_wheels.sources import REQUIREMENTS, InterfacePackage

# The generators' CMake files carry the include folders of another machine, or of an earlier toolchain.
BAKED_PYTHON = re.compile(r'/opt/python/cp[^;">]*?/include/python3\.\d+')
BAKED_NUMPY = re.compile(r'(?<=[;">])/[^;">]*?/numpy/_core/include')


@dataclass(frozen=True)
class Toolchain:
    """Where the generators live, and what CMake needs to know to use them."""

    prefix: Path
    site_packages: Path

    @property
    def python(self) -> Path:
        return self.prefix / "bin" / "python"

    def build(self, package: InterfacePackage, work_dir: Path, jobs: int, log: Path) -> Path:
        """Generate, compile and install `package`; returns the folder that holds the installed tree."""
        environment = clean_environment(
            {
                "PATH": f"{self.prefix / 'bin'}{os.pathsep}{os.environ.get('PATH', os.defpath)}",
                "AMENT_PREFIX_PATH": str(self.prefix),
                "_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1",  # generators load no ROS library: spare each one a second start
            }
        )
        cmake, tree, installed = str(self.prefix / "bin" / "cmake"), str(work_dir / "build"), work_dir / "installed"
        options = {
            "CMAKE_BUILD_TYPE": "Release",
            "CMAKE_C_FLAGS_RELEASE": "-O1",
            "CMAKE_CXX_FLAGS_RELEASE": "-O1",
            "CMAKE_PREFIX_PATH": str(self.prefix),
            "CMAKE_INSTALL_PREFIX": str(installed),
            "Python3_EXECUTABLE": str(self.python),
            "PYTHON_EXECUTABLE": str(self.python),
            "BUILD_TESTING": "OFF",
            "PYTHON_ONLY": "ON",
        }
        flags = [f"-D{name}={value}" for name, value in options.items()]
        configure = [cmake, "-S", str(package.directory), "-B", tree, "-G", "Ninja", *flags]
        run(f"configuring {package.name}", configure, log, environment)
        run(f"compiling {package.name}", [cmake, "--build", tree, "--parallel", str(jobs)], log, environment)
        run(f"installing {package.name}", [cmake, "--install", tree, "--strip"], log, environment)
        return installed

    def version_of(self, distribution: str) -> str:
        """The version of a distribution that the build used."""
        found = next(iter(importlib.metadata.distributions(name=distribution, path=[str(self.site_packages)])))
        return found.version


def require_system_tools() -> None:
    """Raises MissingToolError, naming the apt packages, unless C and C++ can be compiled against Python here."""
    needed = {
        os.environ.get("CC", "gcc"): "gcc",
        os.environ.get("CXX", "g++"): "g++",
    }
    missing = {tool: package for tool, package in needed.items() if shutil.which(tool.split()[0]) is None}
    header = Path(sysconfig.get_path("include")) / "Python.h"
    if not header.is_file():
        missing[str(header)] = "python3-dev"
    if missing:
        raise MissingToolError(list(missing), list(missing.values()))


def make_toolchain(prefix: Path, log: Path) -> Toolchain:
    """Create the environment at `prefix` and make its generators fit this interpreter."""
    venv.create(prefix, symlinks=True)
    site_packages = next(prefix.glob("lib/python3*/site-packages"))
    toolchain = Toolchain(prefix, site_packages)
    run("installing the code generators", [*install_command(toolchain.python), "-r", str(REQUIREMENTS)], log)
    fit(prefix, sysconfig.get_path("include"), site_packages / "numpy" / "_core" / "include")
    return toolchain


def fit(prefix: Path, python_include: str, numpy_include: Path) -> None:
    """Put this interpreter's include folders into the generators' CMake files.

    A file is replaced, never written into: uv links what it installs to its cache, and the next build finds it there.
    """
    for path in prefix.glob("share/*/cmake/*.cmake"):
        text = path.read_text()
        fitted = BAKED_PYTHON.sub(python_include, BAKED_NUMPY.sub(str(numpy_include), text))
        if fitted != text:
            path.unlink()
            path.write_text(fitted)
