"""Back-up and restore: what a service answers, and what an archive says of itself."""

from enum import StrEnum
from typing import Annotated, Final

from pydantic import Field

from contracts.base import Message

FORM: Final = 1
"""Of the archive: a reader refuses a newer one."""
MADE_S_MAX: Final = 253_370_764_800.0
"""The year 9999, in any time zone: a later one is no date."""
SCHEMA_HEADER: Final = "X-Schema-Revision"
"""Of a snapshot: the revision of its schema."""


class BackupRefusal(StrEnum):
    """Codes of `Problem`."""

    USE_PG_DUMP = "use_pg_dump"
    """The database is a server's, which has a back-up of its own."""
    MISSION_ON = "mission_on"
    """A mission runs or waits."""
    RESTORING = "restoring"
    """Nothing begins: a back-up is being restored."""


class BackupService(StrEnum):
    """Databases that cannot be made again, each by the name of its service; the coordinator keeps two."""

    COORDINATOR = "coordinator"
    """The history of missions."""
    EXPLORATION = "exploration"
    """What explorations found out of each home: a file of the coordinator's own."""
    MEMORY = "memory"


Revision = Annotated[str, Field(pattern=r"^[0-9A-Za-z_]{1,32}$", description="of the database's schema")]


class RestoreHold(Message):
    """Of `POST /restore/hold`, and its answer."""

    seconds: float = Field(ge=0.0, le=3600.0, description="from now on no mission begins for so long; 0: lets them")


class RestoreReply(Message):
    """Of `POST /restore`: what the database that was sent holds, and whether it is in use now."""

    applied: bool = Field(description="false: it was only checked")
    revision: Revision
    rows: dict[str, int] = Field(description="how many of each table")
    kept_as: str = Field(default="", description="the file beside the database that keeps what was there before")


class BackedUpDatabase(Message):
    """One file of an archive; `service` says whose database it is."""

    service: BackupService
    revision: Revision
    size_bytes: int = Field(ge=1)
    sha256: str = Field(pattern=r"^[0-9a-f]{64}$")


class BackupManifest(Message):
    """The first file of an archive, `manifest.json`; those of the databases follow in this order."""

    form: int = Field(ge=1, description="of the archive")
    made_s: float = Field(ge=0.0, le=MADE_S_MAX, description="seconds since the Unix epoch")
    databases: tuple[BackedUpDatabase, ...] = Field(min_length=1, max_length=len(BackupService))
