"""Options that every command has."""

from typing import Annotated

import typer

from atom_cli.services import host_of


def _host(said: str) -> str:
    try:
        return host_of(said)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error


Host = Annotated[
    str, typer.Option(envvar="ATOM_HOST", help="where the services listen: a name or an address", callback=_host)
]
PortBase = Annotated[int, typer.Option(envvar="ATOM_PORT_BASE", help="ports are this + 1..5", min=1, max=65000)]
