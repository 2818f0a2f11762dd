"""Views without a thing are found by their colour."""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"


def upgrade() -> None:
    op.create_index(
        "views_of_colour",
        "views",
        ["label", "colour", sa.text("confidence DESC")],
        sqlite_where=sa.text("thing_id IS NULL"),
        postgresql_where=sa.text("thing_id IS NULL"),
    )
