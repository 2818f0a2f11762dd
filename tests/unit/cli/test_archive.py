"""The archive of a back-up: what was written comes back, and whatever else somebody hands over is refused."""

import io
import tarfile
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from atom_cli.archive import ArchiveError, unpack, write
from contracts.backup import FORM, BackupManifest, BackupService

DATABASES = {BackupService.COORDINATOR: b"c" * 1000, BackupService.MEMORY: b"m" * 3_000_000}


@pytest.fixture
def good(tmp_path: Path) -> Path:
    for service, data in DATABASES.items():
        (tmp_path / service).write_bytes(data)
    path = tmp_path / "good.tar"
    write(path, 1000.5, [(one, "0004", tmp_path / one) for one in DATABASES])
    return path


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "out").mkdir()
    return tmp_path / "out"


def test_what_was_written_comes_back(good: Path, folder: Path) -> None:
    manifest, files = unpack(good, folder)
    assert {one: file.read_bytes() for one, file in files.items()} == DATABASES
    assert (manifest.form, manifest.made_s) == (FORM, 1000.5)
    assert good.stat().st_mode & 0o077 == 0


def manifest_of(good: Path) -> BackupManifest:
    with tarfile.open(good) as tar:
        return BackupManifest.model_validate_json(tar.extractfile("manifest.json").read())  # type: ignore[union-attr]


def members(*some: tuple[str, bytes]) -> bytes:
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode="w") as tar:
        for name, data in some:
            info = tarfile.TarInfo(name)
            info.size = len(data)
            tar.addfile(info, io.BytesIO(data))
    return out.getvalue()


def with_manifest(good: Path, **changes: object) -> bytes:
    said = manifest_of(good).model_dump_json()
    for old, new in changes.items():
        said = said.replace(old, str(new))
    text = said.encode()
    return members(("manifest.json", text), *((f"{one}.db", data) for one, data in DATABASES.items()))


def linked(good: Path) -> bytes:
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode="w") as tar:
        info = tarfile.TarInfo("manifest.json")
        info.type, info.linkname = tarfile.SYMTYPE, "/etc/passwd"
        tar.addfile(info)
    return out.getvalue()


def named(name: str) -> Callable[[Path], bytes]:
    def made(good: Path) -> bytes:
        first = manifest_of(good).model_dump_json().encode()
        return members(("manifest.json", first), (name, DATABASES[BackupService.COORDINATOR]))

    return made


def spoilt(good: Path) -> bytes:
    data = bytearray(good.read_bytes())
    data[len(data) // 2] ^= 1
    return bytes(data)


HOSTILE: dict[str, tuple[Callable[[Path], bytes], str]] = {
    "empty": (lambda good: b"", "no back-up of ours"),
    "text": (lambda good: b"hello\n" * 1000, "no back-up of ours"),
    "another tar": (lambda good: members(("a.txt", b"a")), "'a.txt' where manifest.json should be"),
    "a path out of the folder": (named("../../coordinator.db"), "where coordinator.db should be"),
    "an absolute path": (named("/tmp/coordinator.db"), "where coordinator.db should be"),
    "a link": (linked, "no back-up of ours"),
    "a name too long for a header": (named("x" * 300), "where coordinator.db should be"),
    "cut off in a database": (lambda good: good.read_bytes()[:2_000_000], "cut off"),
    "cut off in the manifest": (lambda good: good.read_bytes()[:600], "cut off"),
    "cut off between two": (lambda good: good.read_bytes()[:1024], "cut off before coordinator.db"),
    "spoilt": (spoilt, "its SHA-256 is another one"),
    "something behind": (lambda good: good.read_bytes() + b"x", "that its manifest does not name"),
    "much behind": (lambda good: good.read_bytes() + bytes(5_000_000), "that its manifest does not name"),
    "no manifest": (lambda good: members(("manifest.json", b"{}")), "not ours, or of a newer program"),
    "a huge manifest": (lambda good: members(("manifest.json", b" " * 70_000)), "manifest is too large"),
    "of a newer form": (lambda good: with_manifest(good, **{'"form":1': '"form":2'}), "a newer program made it"),
    "of no year": (lambda good: with_manifest(good, **{"1000.5": "1e300"}), "not ours, or of a newer program"),
    "another size": (lambda good: with_manifest(good, **{":1000,": ":1001,"}), "another size"),
    "one twice": (lambda good: with_manifest(good, memory="coordinator"), "twice"),
    "a service nobody knows": (lambda good: with_manifest(good, memory="robot"), "not ours, or of a newer program"),
}


@pytest.mark.parametrize("kind", HOSTILE)
def test_what_is_no_back_up_of_ours_is_named(kind: str, good: Path, folder: Path, tmp_path: Path) -> None:
    made, said = HOSTILE[kind]
    bad = tmp_path / "bad.tar"
    bad.write_bytes(made(good))
    with pytest.raises(ArchiveError, match=said):
        unpack(bad, folder)
    assert {one.name for one in folder.iterdir()} <= {"coordinator.db", "memory.db"}


@given(data=st.binary(max_size=3000))
def test_whatever_is_handed_over_is_refused_by_name(data: bytes, tmp_path_factory: pytest.TempPathFactory) -> None:
    place = tmp_path_factory.mktemp("any")
    (place / "bad.tar").write_bytes(data)
    with pytest.raises(ArchiveError):
        unpack(place / "bad.tar", place)
