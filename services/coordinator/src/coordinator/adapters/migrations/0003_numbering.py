"""Numbers that were given are known also where what bore them is gone: a restore takes events away, not their ids."""

from alembic import op

revision = "0003"
down_revision = "0002"


def upgrade() -> None:
    op.execute("CREATE TABLE numbering (name TEXT NOT NULL, next INTEGER NOT NULL, PRIMARY KEY (name))")
