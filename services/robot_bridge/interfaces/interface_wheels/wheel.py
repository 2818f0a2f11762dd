"""Packs the installed tree of one interface package as a platform wheel (PEP 427)."""

import base64
import csv
import hashlib
import io
import sys
import sysconfig
import zipfile
from collections.abc import Sequence
from pathlib import Path

from interface_wheels.sources import InterfacePackage

INTERFACE_SUFFIXES = frozenset({".msg", ".srv", ".action", ".idl", ".json", ".xml"})
EPOCH = (1980, 1, 1, 0, 0, 0)  # the earliest a zip can say: equal input gives equal bytes


def wheel_tag() -> str:
    """This interpreter's tag, such as cp311-cp311-linux_x86_64."""
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    return f"{python}-{python}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"


def pack_wheel(
    installed: Path, package: InterfacePackage, version: str, requires: Sequence[str], output_dir: Path
) -> Path:
    """Write the wheel of `package` from its `installed` tree; returns its path.

    The Python module goes to site-packages, the shared libraries to the environment's `lib`, where the library path
    that the ROS wheels set up finds them, and the interface files and ament's index to `share`.
    """
    distribution = package.distribution
    files = _python_files(installed, package.name) | _data_files(installed, f"{distribution}-{version}.data/data")
    info = f"{distribution}-{version}.dist-info"
    metadata = ["Metadata-Version: 2.1", f"Name: {distribution.replace('_', '-')}", f"Version: {version}"]
    metadata += [f"Requires-Dist: {requirement}" for requirement in requires]
    files[f"{info}/METADATA"] = "\n".join([*metadata, ""]).encode()
    wheel = ["Wheel-Version: 1.0", "Generator: interface_wheels", "Root-Is-Purelib: false", f"Tag: {wheel_tag()}", ""]
    files[f"{info}/WHEEL"] = "\n".join(wheel).encode()
    files[f"{info}/RECORD"] = _record(files, f"{info}/RECORD")
    path = output_dir / f"{distribution}-{version}-{wheel_tag()}.whl"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o100755 if ".so" in Path(name).suffixes else 0o100644) << 16
            archive.writestr(entry, content)
    return path


def _python_files(installed: Path, package: str) -> dict[str, bytes]:
    site_packages = next(installed.glob("lib/python3*/site-packages"))
    paths = sorted((site_packages / package).rglob("*"))
    kept = [path for path in paths if path.suffix in {".py", ".so"} and "__pycache__" not in path.parts]
    return {path.relative_to(site_packages).as_posix(): path.read_bytes() for path in kept}


def _data_files(installed: Path, prefix: str) -> dict[str, bytes]:
    libraries = sorted(installed.glob("lib/*.so*"))
    shared = sorted(path for path in (installed / "share").rglob("*") if path.is_file())
    kept = [path for path in shared if path.suffix in INTERFACE_SUFFIXES or "ament_index" in path.parts]
    return {f"{prefix}/{path.relative_to(installed).as_posix()}": path.read_bytes() for path in [*libraries, *kept]}


def _record(files: dict[str, bytes], record: str) -> bytes:
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    for name, content in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        rows.writerow([name, f"sha256={digest}", len(content)])
    rows.writerow([record, "", ""])
    return text.getvalue().encode()
