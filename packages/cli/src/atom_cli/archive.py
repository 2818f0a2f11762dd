"""The archive of a back-up: an uncompressed tar (ustar) of `manifest.json` and one SQLite file for each service.

Its headers are read here, one block at a time, and only those that `write` makes are taken: no link, no folder, no
extension, no name but the expected one. Nothing is ever unpacked to a name that an archive gives.

ArchiveError     the file is no archive of ours, is damaged, or of a newer program
"""

import hashlib
import io
import os
import tarfile
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO, Final

from pydantic import ValidationError

from contracts.backup import FORM, BackedUpDatabase, BackupManifest, BackupService

MANIFEST: Final = "manifest.json"
MANIFEST_BYTES_MAX: Final = 65_536
DATABASE_BYTES_MAX: Final = 8 * 1024**3 - 1
"""What ustar can say."""
PART_BYTES: Final = 1 << 20


class ArchiveError(Exception):
    pass


def write(path: Path, made_s: float, databases: Sequence[tuple[BackupService, str, Path]]) -> BackupManifest:
    """A new file, for its owner alone. Each database is (service, revision, file).

    Raises `OSError`, and `ArchiveError` for a database that is too large.
    """
    manifest = BackupManifest(form=FORM, made_s=made_s, databases=tuple(_described(*one) for one in databases))
    text = manifest.model_dump_json(indent=2).encode()
    with sealed(path) as file:
        with tarfile.open(fileobj=file, mode="w", format=tarfile.USTAR_FORMAT) as tar:
            tar.addfile(_member(MANIFEST, len(text), made_s), io.BytesIO(text))
            for described, (_, _, source) in zip(manifest.databases, databases, strict=True):
                with source.open("rb") as content:
                    tar.addfile(_member(_name_of(described.service), described.size_bytes, made_s), content)
        file.flush()
        os.fsync(file.fileno())
    return manifest


def unpack(path: Path, folder: Path) -> tuple[BackupManifest, dict[BackupService, Path]]:
    """Each database as a file of our naming in `folder`, checked to be what the manifest says.

    Raises `ArchiveError`, and `OSError` where it cannot be read or `folder` is full.
    """
    with path.open("rb") as file:
        manifest = _manifest(file)
        files: dict[BackupService, Path] = {}
        for one in manifest.databases:
            if one.service in files:
                raise ArchiveError(f"it holds {one.service} twice")
            files[one.service] = folder / _name_of(one.service)
            _unpack_one(file, one, files[one.service])
        if any(file.read(PART_BYTES)) or file.read(1):
            raise ArchiveError("something follows that its manifest does not name")
    return manifest, files


@contextmanager
def sealed(path: Path) -> Generator[BinaryIO]:
    """A new file, to be written and read by its owner alone."""
    with os.fdopen(os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600), "w+b") as file:
        yield file


def _described(service: BackupService, revision: str, source: Path) -> BackedUpDatabase:
    size_bytes = source.stat().st_size
    if size_bytes > DATABASE_BYTES_MAX:
        raise ArchiveError(f"the database of {service} is too large for an archive: {size_bytes} bytes")
    with source.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    return BackedUpDatabase(service=service, revision=revision, size_bytes=size_bytes, sha256=digest)


def _manifest(file: BinaryIO) -> BackupManifest:
    size_bytes = _header(file, MANIFEST)
    if size_bytes > MANIFEST_BYTES_MAX:
        raise ArchiveError("its manifest is too large")
    text = b"".join(_content(file, size_bytes))
    try:
        manifest = BackupManifest.model_validate_json(text)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise ArchiveError(f"its manifest is not ours, or of a newer program: {where} {first['msg']}") from error
    if manifest.form > FORM:
        raise ArchiveError(f"a newer program made it (form {manifest.form}; this one knows {FORM})")
    return manifest


def _unpack_one(file: BinaryIO, expected: BackedUpDatabase, place: Path) -> None:
    if _header(file, _name_of(expected.service)) != expected.size_bytes:
        raise ArchiveError(f"the database of {expected.service} has another size than its manifest says")
    digest = hashlib.sha256()
    with sealed(place) as out:
        for part in _content(file, expected.size_bytes):
            digest.update(part)
            out.write(part)
    if digest.hexdigest() != expected.sha256:
        raise ArchiveError(f"the database of {expected.service} is damaged: its SHA-256 is another one")


def _header(file: BinaryIO, name: str) -> int:
    """The size of the member that comes next, in bytes."""
    try:
        info = tarfile.TarInfo.frombuf(file.read(tarfile.BLOCKSIZE), "utf-8", "strict")
    except (tarfile.HeaderError, ValueError) as error:
        raise ArchiveError(f"it is no back-up of ours, or cut off before {name}") from error
    if info.type != tarfile.REGTYPE or info.name != name or info.size < 0:
        raise ArchiveError(f"it is no back-up of ours: {info.name[:80]!r} where {name} should be")
    return info.size


def _content(file: BinaryIO, size_bytes: int) -> Iterator[bytes]:
    left = size_bytes
    while left:
        part = file.read(min(left, PART_BYTES))
        if not part:
            raise ArchiveError("it is cut off")
        left -= len(part)
        yield part
    file.read(-size_bytes % tarfile.BLOCKSIZE)


def _member(name: str, size_bytes: int, made_s: float) -> tarfile.TarInfo:
    info = tarfile.TarInfo(name)
    info.size, info.mode, info.mtime = size_bytes, 0o600, int(made_s)
    return info


def _name_of(service: BackupService) -> str:
    return f"{service.value}.db"
