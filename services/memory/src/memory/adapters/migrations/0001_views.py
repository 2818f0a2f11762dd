"""Views alone: the schema from before there were migrations."""

from alembic import op

revision = "0001"
down_revision = None


def upgrade() -> None:
    op.execute("CREATE TABLE schema_version (version INTEGER NOT NULL)")
    op.execute(
        """
        CREATE TABLE views (
            id INTEGER NOT NULL, label TEXT NOT NULL, colour TEXT NOT NULL,
            cell_x INTEGER NOT NULL, cell_y INTEGER NOT NULL, sector INTEGER NOT NULL,
            x FLOAT NOT NULL, y FLOAT NOT NULL, yaw FLOAT NOT NULL,
            confidence FLOAT NOT NULL, last_seen_s FLOAT NOT NULL, count INTEGER NOT NULL,
            PRIMARY KEY (id), UNIQUE (label, colour, cell_x, cell_y, sector)
        )
        """
    )
    op.execute("CREATE INDEX views_best_first ON views (label, confidence DESC)")
    op.execute("INSERT INTO schema_version (version) VALUES (1)")
