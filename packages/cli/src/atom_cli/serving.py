"""`atom mcp`: for programs that start their MCP servers themselves."""

import sys
from collections.abc import Callable
from importlib import import_module
from typing import Final

import httpx
import typer

from atom_cli.options import Host, PortBase
from atom_cli.services import PORTS

EXIT_AWAY: Final = 4


def add_to(app: typer.Typer, key: Callable[[], str]) -> None:
    @app.command()
    def mcp(host: Host = "127.0.0.1", port_base: PortBase = 8000) -> None:  # pyright: ignore[reportUnusedFunction]
        """The actions as MCP tools over stdin and stdout, for a client that starts this program (docs/mcp.md)."""
        try:
            stdio = import_module("atom_cli.mcp_stdio")
        except ModuleNotFoundError as error:
            raise typer.BadParameter(f"{error.name} is not installed: pip install 'atom-cli[mcp]'") from error
        url = httpx.URL(scheme="http", host=host, port=port_base + PORTS["coordinator"], path="/mcp")
        why = stdio.run(str(url), key())
        if why:
            print(f"no MCP server at {url}: {why}", file=sys.stderr)  # noqa: T201 - stdout belongs to the protocol
            raise typer.Exit(EXIT_AWAY)
