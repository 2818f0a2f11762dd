"""Missions, their timelines, recordings and pictures: the schema from before there were migrations."""

from alembic import op

revision = "0001"
down_revision = None

TABLES = (
    "CREATE TABLE schema_version (version INTEGER NOT NULL)",
    """
    CREATE TABLE missions (
        number INTEGER NOT NULL, id TEXT NOT NULL, over BOOLEAN NOT NULL, record TEXT NOT NULL,
        PRIMARY KEY (number), UNIQUE (id)
    )
    """,
    "CREATE TABLE events (id INTEGER NOT NULL, mission_id TEXT NOT NULL, line TEXT NOT NULL, PRIMARY KEY (id))",
    "CREATE INDEX events_of_mission ON events (mission_id, id)",
    """
    CREATE TABLE recordings (
        number INTEGER NOT NULL, mission_id TEXT NOT NULL, lines BLOB NOT NULL, PRIMARY KEY (number)
    )
    """,
    "CREATE INDEX ix_recordings_mission_id ON recordings (mission_id)",
    """
    CREATE TABLE pictures (
        mission_id TEXT NOT NULL, number INTEGER NOT NULL, jpeg BLOB NOT NULL, PRIMARY KEY (mission_id, number)
    )
    """,
    'CREATE TABLE requests ("key" TEXT NOT NULL, digest TEXT NOT NULL, mission_ids TEXT NOT NULL, PRIMARY KEY ("key"))',
    "INSERT INTO schema_version (version) VALUES (1)",
)


def upgrade() -> None:
    for statement in TABLES:
        op.execute(statement)
