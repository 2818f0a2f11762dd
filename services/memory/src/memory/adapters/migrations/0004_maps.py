"""What is remembered belongs to a map.

What was there before is of map 0, which has no name yet: it is the first map that the robot is in from now on.
"""

import sqlalchemy as sa
from alembic import op
from sqlalchemy.dialects import postgresql

revision = "0004"
down_revision = "0003"

Real = sa.Float().with_variant(postgresql.DOUBLE_PRECISION(), "postgresql")


def upgrade() -> None:
    op.create_table(
        "maps",
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("id", sa.Text, nullable=False, unique=True),
        sa.Column("last_seen_s", Real, nullable=False),
    )
    op.execute("INSERT INTO maps (number, id, last_seen_s) VALUES (0, '', 0)")
    for table in ("things", "views"):
        op.add_column(table, sa.Column("map_number", sa.Integer, nullable=False, server_default="0"))
    for name in ("things_of_label", "things_at"):
        op.drop_index(name, table_name="things")
    for name in ("views_place", "views_best_first", "views_of_colour"):
        op.drop_index(name, table_name="views")
    op.create_index("things_of_label", "things", ["map_number", "label"])
    op.create_index("things_at", "things", ["map_number", "x", "y"])
    op.execute(
        "CREATE UNIQUE INDEX views_place ON views "
        "(map_number, cell_x, cell_y, sector, label, colour, coalesce(thing_id, 0))"
    )
    op.create_index("views_best_first", "views", ["map_number", "label", sa.text("confidence DESC")])
    op.create_index(
        "views_of_colour",
        "views",
        ["map_number", "label", "colour", sa.text("confidence DESC")],
        sqlite_where=sa.text("thing_id IS NULL"),
        postgresql_where=sa.text("thing_id IS NULL"),
    )
