"""The keys a service knows, read from its file again whenever that changes."""

import hmac
import time
from pathlib import Path
from typing import Final

import structlog
from pydantic import ValidationError

from contracts.access import CredentialFile, Principal, sha256_of

log = structlog.get_logger()

LOOK_S: Final = 1.0
"""Between two looks at the file's time: so soon a revoked key ends."""
_NOBODY: Final = "0" * 64


class CredentialStore:
    """Raises `ValueError` when the file cannot be read at the start. Later a broken one leaves the keys as they are."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self._looked_s = time.monotonic()
        self._seen = self._stamp()
        self._principals = self._read()

    def by_key(self, key: str) -> Principal | None:
        """Compared with every key in constant time, so that an answer's time tells nothing of how close it was."""
        self._look()
        asked = sha256_of(key)
        found = [one for one in self._principals if hmac.compare_digest(asked, one.key_sha256 or _NOBODY)]
        return found[0] if found else None

    def by_name(self, name: str) -> Principal | None:
        self._look()
        return next((one for one in self._principals if one.name == name), None)

    def _look(self) -> None:
        if time.monotonic() - self._looked_s < LOOK_S:
            return
        self._looked_s = time.monotonic()
        stamp = self._stamp()
        if stamp == self._seen:
            return
        self._seen = stamp
        try:
            self._principals = self._read()
            log.info("the keys were read again", principals=len(self._principals))
        except ValueError as error:
            log.error("the keys stay as they were", reason=str(error))  # noqa: TRY400 - a sentence, not a trace

    def _stamp(self) -> tuple[int, int, int] | None:
        """Another one after each change, of its permissions too; None while it cannot be looked at."""
        try:
            found = self._file.stat()
        except OSError:
            return None
        return found.st_ctime_ns, found.st_ino, found.st_size

    def _read(self) -> tuple[Principal, ...]:
        try:
            return CredentialFile.model_validate_json(self._file.read_bytes()).principals
        except OSError as error:
            raise ValueError(f"{self._file}: {error.strerror}") from error
        except ValidationError as error:
            raise ValueError(f"{self._file} is no file of keys: {error.errors()[0]['msg']}") from None
