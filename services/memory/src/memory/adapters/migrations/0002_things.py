"""Things with places of their own, belief, and views that say which thing they show.

`things` and `views` are written out here, not taken from `tables`: a migration must stay what it was.
"""

import sqlalchemy as sa
from alembic import op
from sqlalchemy.dialects import postgresql

revision = "0002"
down_revision = "0001"

Real = sa.Float().with_variant(postgresql.DOUBLE_PRECISION(), "postgresql")

BELIEF_OF_OLD_VIEWS = "1.0 - 1.0 / (2.0 + 20.0 * confidence * confidence)"
"""As one sighting of that confidence would give."""


def upgrade() -> None:
    op.create_table(
        "things",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("label", sa.Text, nullable=False),
        *(sa.Column(name, Real, nullable=False) for name in ("x", "y", "z", "variance_m2", "belief", "believed_s")),
        *(sa.Column(name, Real, nullable=False) for name in ("confidence", "first_seen_s", "last_seen_s")),
        sa.Column("times_seen", sa.Integer, nullable=False),
        sa.Column("colours", sa.Text, nullable=False),
        sa.Column("times_missed", sa.Integer, nullable=False),
        sa.Column("last_missed_s", Real),
        *(sa.Column(name, Real, nullable=False) for name in ("miss_x", "miss_y", "miss_loss")),
        sa.Column("moved_from", sa.Integer, sa.ForeignKey("things.id", ondelete="SET NULL")),
        sa.Column("moved_to", sa.Integer, sa.ForeignKey("things.id", ondelete="SET NULL")),
        sa.Column("embedding_model", sa.Text, nullable=False),
        sa.Column("embedding", sa.LargeBinary, nullable=False),
        sqlite_autoincrement=True,
    )
    op.create_index("things_of_label", "things", ["label"])
    op.create_index("things_at", "things", ["x", "y"])
    op.drop_index("views_best_first", table_name="views")
    op.rename_table("views", "old_views")
    op.create_table(
        "views_of_things",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("label", sa.Text, nullable=False),
        sa.Column("colour", sa.Text, nullable=False),
        *(sa.Column(name, sa.Integer, nullable=False) for name in ("cell_x", "cell_y", "sector")),
        sa.Column("thing_id", sa.Integer, sa.ForeignKey("things.id", ondelete="CASCADE")),
        *(sa.Column(name, Real, nullable=False) for name in ("x", "y", "yaw", "confidence", "last_seen_s")),
        sa.Column("sightings", sa.Integer, nullable=False),
        *(sa.Column(name, Real, nullable=False) for name in ("belief", "believed_s")),
    )
    op.execute(
        f"""
        INSERT INTO views_of_things (label, colour, cell_x, cell_y, sector, x, y, yaw, confidence, last_seen_s,
                                     sightings, belief, believed_s)
        SELECT label, colour, cell_x, cell_y, sector, x, y, yaw, confidence, last_seen_s, count,
               {BELIEF_OF_OLD_VIEWS}, last_seen_s FROM old_views ORDER BY id
        """
    )
    op.drop_table("old_views")
    op.rename_table("views_of_things", "views")
    op.execute(
        "CREATE UNIQUE INDEX views_place ON views (cell_x, cell_y, sector, label, colour, coalesce(thing_id, 0))"
    )
    op.execute("CREATE INDEX views_best_first ON views (label, confidence DESC)")
    op.execute("CREATE INDEX views_of_thing ON views (thing_id, label, confidence DESC)")
    op.drop_table("schema_version")
