"""The database's tables, and the version that says which code understands them."""

from sqlalchemy import Column, Float, Index, Integer, MetaData, Table, Text, UniqueConstraint
from sqlalchemy.dialects import sqlite
from sqlalchemy.schema import CreateIndex, CreateTable

SCHEMA_VERSION = 1

metadata = MetaData()

schema_version = Table("schema_version", metadata, Column("version", Integer, nullable=False))

views = Table(
    "views",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("label", Text, nullable=False),
    Column("colour", Text, nullable=False),  # empty: not known (SQL takes two NULLs for different)
    Column("cell_x", Integer, nullable=False),
    Column("cell_y", Integer, nullable=False),
    Column("sector", Integer, nullable=False),
    Column("x", Float, nullable=False),
    Column("y", Float, nullable=False),
    Column("yaw", Float, nullable=False),
    Column("confidence", Float, nullable=False),
    Column("last_seen_s", Float, nullable=False),
    Column("count", Integer, nullable=False),
    UniqueConstraint("label", "colour", "cell_x", "cell_y", "sector"),
)
Index("views_best_first", views.c.label, views.c.confidence.desc())


def definitions() -> list[str]:
    """The statements that make an empty database ours."""
    made = [CreateTable(table) for table in metadata.sorted_tables]
    made += [CreateIndex(index) for table in metadata.sorted_tables for index in sorted(table.indexes, key=str)]
    statements = [str(one.compile(dialect=sqlite.dialect())) for one in made]
    return [*statements, f"INSERT INTO schema_version (version) VALUES ({SCHEMA_VERSION})"]
