"""The generators' CMake files are made to fit this interpreter, and nothing outside the toolchain changes."""

import os
from pathlib import Path

import pytest
from interface_wheels.toolchain import fit

INCLUDES = 'INTERFACE_INCLUDE_DIRECTORIES "{python};{numpy}"\n'


@pytest.mark.parametrize(
    "baked",
    [
        ("/opt/python/cp311-cp311/include/python3.11", "/opt/python/cp311-cp311/lib/x/numpy/_core/include"),
        ("/usr/include/python3.11", "/home/someone/.cache/atom/.build-1/toolchain/lib/x/numpy/_core/include"),
    ],
)
def test_include_folders_of_elsewhere_become_those_of_here_and_a_linked_cache_stays_as_it_is(
    tmp_path: Path, baked: tuple[str, str]
) -> None:
    cached = tmp_path / "cache" / "some_msgsExport.cmake"
    installed = tmp_path / "toolchain" / "share" / "some_msgs" / "cmake" / cached.name
    cached.parent.mkdir()
    installed.parent.mkdir(parents=True)
    before = INCLUDES.format(python=baked[0], numpy=baked[1])
    cached.write_text(before)
    os.link(cached, installed)  # as uv installs
    fit(tmp_path / "toolchain", "/usr/include/python3.11", Path("/here/numpy/_core/include"))
    assert installed.read_text() == INCLUDES.format(python="/usr/include/python3.11", numpy="/here/numpy/_core/include")
    assert cached.read_text() == before
