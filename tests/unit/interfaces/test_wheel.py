"""A wheel carries what runs, in the places where Python and the ROS wheels look for it."""

import base64
import csv
import hashlib
import zipfile
from pathlib import Path

from interface_wheels.sources import InterfacePackage
from interface_wheels.wheel import pack_wheel, wheel_tag

PACKAGE = InterfacePackage("some_msgs", "1.2.3", ("std_msgs",), Path("some_msgs"))


def installed_tree(root: Path) -> Path:
    site_packages = root / "lib/python3.11/site-packages"
    for name in (
        site_packages / "some_msgs/msg/_thing.py",
        site_packages / "some_msgs/some_msgs_s__rosidl_typesupport_c.so",
        site_packages / "some_msgs/__pycache__/x.pyc",
        site_packages / "some_msgs-1.2.3-py3.11.egg-info/PKG-INFO",
        root / "lib/libsome_msgs__rosidl_generator_c.so",
        root / "include/some_msgs/thing.h",
        root / "share/some_msgs/msg/Thing.msg",
        root / "share/some_msgs/cmake/some_msgsConfig.cmake",
        root / "share/ament_index/resource_index/packages/some_msgs",
    ):
        name.parent.mkdir(parents=True, exist_ok=True)
        name.write_text(name.name)
    return root


def pack(tmp_path: Path) -> Path:
    return pack_wheel(installed_tree(tmp_path / "tree"), PACKAGE, "1.2.3+gabc", ["ros-std-msgs~=5.3.6"], tmp_path)


def test_modules_libraries_and_definitions_are_in_and_what_only_compilers_need_is_not(tmp_path: Path) -> None:
    with zipfile.ZipFile(pack(tmp_path)) as wheel:
        names = set(wheel.namelist())
    data = "atom_some_msgs-1.2.3+gabc.data/data"
    info = "atom_some_msgs-1.2.3+gabc.dist-info"
    assert names == {
        "some_msgs/msg/_thing.py",
        "some_msgs/some_msgs_s__rosidl_typesupport_c.so",
        f"{data}/lib/libsome_msgs__rosidl_generator_c.so",
        f"{data}/share/some_msgs/msg/Thing.msg",
        f"{data}/share/ament_index/resource_index/packages/some_msgs",
        f"{info}/METADATA",
        f"{info}/WHEEL",
        f"{info}/RECORD",
    }


def test_the_record_lists_every_file_with_its_digest(tmp_path: Path) -> None:
    with zipfile.ZipFile(pack(tmp_path)) as wheel:
        record = next(name for name in wheel.namelist() if name.endswith("RECORD"))
        rows = {row[0]: row[1:] for row in csv.reader(wheel.read(record).decode().splitlines())}
        assert set(rows) == set(wheel.namelist())
        digest = base64.urlsafe_b64encode(hashlib.sha256(wheel.read("some_msgs/msg/_thing.py")).digest())
        assert rows["some_msgs/msg/_thing.py"][0] == f"sha256={digest.rstrip(b'=').decode()}"


def test_the_metadata_names_the_runtime_it_needs_and_the_file_name_this_interpreter(tmp_path: Path) -> None:
    path = pack(tmp_path)
    assert path.name == f"atom_some_msgs-1.2.3+gabc-{wheel_tag()}.whl"
    with zipfile.ZipFile(path) as wheel:
        metadata = wheel.read("atom_some_msgs-1.2.3+gabc.dist-info/METADATA").decode()
    assert "Requires-Dist: ros-std-msgs~=5.3.6\n" in metadata


def test_equal_input_gives_equal_bytes(tmp_path: Path) -> None:
    assert pack(tmp_path).read_bytes() == pack(tmp_path).read_bytes()
