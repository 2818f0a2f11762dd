"""The database's tables as they are now; `migrations` brings older ones here."""

from pathlib import Path
from typing import Any

from sqlalchemy import (
    Column,
    ColumnElement,
    Float,
    ForeignKey,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    Table,
    Text,
    literal_column,
)
from sqlalchemy.dialects import postgresql

MIGRATIONS = Path(__file__).with_name("migrations")

metadata = MetaData()

Real = Float().with_variant(postgresql.DOUBLE_PRECISION(), "postgresql")

maps = Table(
    "maps",
    metadata,
    Column("number", Integer, primary_key=True),
    Column("id", Text, nullable=False, unique=True),  # empty: nobody knows which map it was
    Column("last_seen_s", Real, nullable=False),
)

rooms = Table(
    "rooms",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("map_number", Integer, nullable=False),
    Column("number", Integer, nullable=False),  # 'unnamed room 3'
    Column("x", Real, nullable=False),
    Column("y", Real, nullable=False),
    Column("name", Text, nullable=False),  # a person's; empty: nobody named it
    sqlite_autoincrement=True,  # an id is never given twice: a page may still show the old one
)
Index("rooms_of_map", rooms.c.map_number)

things = Table(
    "things",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("map_number", Integer, nullable=False),
    Column("label", Text, nullable=False),
    Column("x", Real, nullable=False),
    Column("y", Real, nullable=False),
    Column("z", Real, nullable=False),
    Column("variance_m2", Real, nullable=False),
    Column("belief", Real, nullable=False),
    Column("believed_s", Real, nullable=False),
    Column("confidence", Real, nullable=False),
    Column("first_seen_s", Real, nullable=False),
    Column("last_seen_s", Real, nullable=False),
    Column("times_seen", Integer, nullable=False),
    Column("colours", Text, nullable=False),  # JSON: faded votes by colour word
    Column("times_missed", Integer, nullable=False),
    Column("last_missed_s", Real),
    Column("miss_x", Real, nullable=False),
    Column("miss_y", Real, nullable=False),
    Column("miss_loss", Real, nullable=False),
    Column("moved_from", Integer, ForeignKey("things.id", ondelete="SET NULL")),
    Column("moved_to", Integer, ForeignKey("things.id", ondelete="SET NULL")),
    Column("embedding_model", Text, nullable=False),
    Column("embedding", LargeBinary, nullable=False),  # float16, little-endian
    sqlite_autoincrement=True,  # an id is never given twice: a page may still show the old one
)
Index("things_of_label", things.c.map_number, things.c.label)
Index("things_at", things.c.map_number, things.c.x, things.c.y)

views = Table(
    "views",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("map_number", Integer, nullable=False),
    Column("label", Text, nullable=False),
    Column("colour", Text, nullable=False),  # empty: not known, or the thing's
    Column("cell_x", Integer, nullable=False),
    Column("cell_y", Integer, nullable=False),
    Column("sector", Integer, nullable=False),
    Column("thing_id", Integer, ForeignKey("things.id", ondelete="CASCADE")),
    Column("x", Real, nullable=False),
    Column("y", Real, nullable=False),
    Column("yaw", Real, nullable=False),
    Column("confidence", Real, nullable=False),
    Column("last_seen_s", Real, nullable=False),
    Column("sightings", Integer, nullable=False),
    Column("belief", Real, nullable=False),
    Column("believed_s", Real, nullable=False),
)
NO_THING: ColumnElement[int] = literal_column("coalesce(thing_id, 0)")
"""SQL takes two NULLs for different; a key must not."""
PLACE: tuple[ColumnElement[Any], ...] = (
    views.c.map_number,
    views.c.cell_x,
    views.c.cell_y,
    views.c.sector,
    views.c.label,
    views.c.colour,
    NO_THING,
)
Index("views_place", *PLACE, unique=True)
Index("views_best_first", views.c.map_number, views.c.label, views.c.confidence.desc())
Index("views_of_thing", views.c.thing_id, views.c.label, views.c.confidence.desc())
Index(
    "views_of_colour",
    views.c.map_number,
    views.c.label,
    views.c.colour,
    views.c.confidence.desc(),
    sqlite_where=views.c.thing_id.is_(None),
    postgresql_where=views.c.thing_id.is_(None),
)
