"""The database's tables as they are now; `migrations` brings older ones here."""

from pathlib import Path

from sqlalchemy import Boolean, Column, Index, Integer, LargeBinary, MetaData, Table, Text

MIGRATIONS = Path(__file__).with_name("migrations")

metadata = MetaData()

missions = Table(
    "missions",
    metadata,
    Column("number", Integer, primary_key=True),  # in the order they were asked for
    Column("id", Text, nullable=False, unique=True),
    Column("over", Boolean, nullable=False),
    Column("record", Text, nullable=False),  # contracts.mission.Mission, JSON
)

events = Table(
    "events",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("mission_id", Text, nullable=False),
    Column("line", Text, nullable=False),  # contracts.mission.MissionEvent, JSON
)
Index("events_of_mission", events.c.mission_id, events.c.id)

recordings = Table(
    "recordings",
    metadata,
    Column("number", Integer, primary_key=True),
    Column("mission_id", Text, nullable=False, index=True),
    Column("lines", LargeBinary, nullable=False),  # zlib of lines of core.recording
)

pictures = Table(
    "pictures",
    metadata,
    Column("mission_id", Text, primary_key=True),
    Column("number", Integer, primary_key=True),
    Column("jpeg", LargeBinary, nullable=False),
)

requests = Table(
    "requests",
    metadata,
    Column("key", Text, primary_key=True),
    Column("digest", Text, nullable=False),
    Column("mission_ids", Text, nullable=False),  # separated by spaces
)

numbering = Table(
    "numbering",
    metadata,
    Column("name", Text, primary_key=True),  # EVENTS
    Column("next", Integer, nullable=False),  # no lower number is given again, whatever the other tables hold
)
EVENTS = "events"
