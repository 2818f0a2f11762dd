"""Brings a database from any of its schema's versions to the newest, with Alembic."""

from pathlib import Path

from alembic import command
from alembic.config import Config
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import Connection, inspect, text

from mesh.errors import UnavailableError

FIRST = "0001"
BEFORE_ALEMBIC = "schema_version"
"""The table that told the version of databases made before there were migrations: 1, which is now 0001."""


class UnknownSchemaError(UnavailableError):
    """The tables are not ours, or newer than this program."""


def upgrade(connection: Connection, migrations: Path) -> None:
    """Runs the scripts in the folder `migrations` inside the caller's transaction, so that all of it happens or none.

    Raises `UnknownSchemaError` where the tables are not ours, or newer than this program.
    """
    config = Config()
    config.set_main_option("path_separator", "newline")
    config.set_main_option("script_location", str(Path(__file__).with_name("alembic_env")))
    config.set_main_option("version_locations", str(migrations))
    scripts = ScriptDirectory.from_config(config)
    context = MigrationContext.configure(connection)
    tables = set(inspect(connection).get_table_names())
    if tables and "alembic_version" not in tables:
        _check_it_is_ours(connection, tables)
        context.stamp(scripts, FIRST)
    found = context.get_current_revision()
    if found == scripts.get_current_head():
        return
    if found is not None and found not in {script.revision for script in scripts.walk_revisions()}:
        raise UnknownSchemaError("database", f"it has the schema {found} of a newer program; it was left alone")
    config.attributes["connection"] = connection
    command.upgrade(config, "head")


def current_revision(connection: Connection) -> str:
    """The schema's version; the first one's where the tables are from before there were migrations."""
    return MigrationContext.configure(connection).get_current_revision() or FIRST


def _check_it_is_ours(connection: Connection, tables: set[str]) -> None:
    if BEFORE_ALEMBIC not in tables:
        raise UnknownSchemaError("database", "it holds another program's tables; it was left alone")
    version = connection.execute(text("SELECT max(version) FROM schema_version")).scalar()
    if version != 1:
        raise UnknownSchemaError("database", f"it has schema version {version}, which is not known; it was left alone")
