"""What an exploration knows of a home, one row a home."""

from alembic import op

revision = "0001"
down_revision = None


def upgrade() -> None:
    op.execute("CREATE TABLE explorations (home TEXT NOT NULL, memory TEXT NOT NULL, PRIMARY KEY (home))")
