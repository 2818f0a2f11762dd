"""`atom mcp`: the coordinator's MCP server for clients that start a program and speak over its stdin and stdout.

It adds nothing and decides nothing: each request is passed on to `/mcp`, with the key of whoever started it.
"""

from typing import Any

import anyio
import httpx2
from mcp import Client, types
from mcp.client.streamable_http import streamable_http_client
from mcp.server.context import ServerRequestContext
from mcp.server.lowlevel import Server
from mcp.server.stdio import stdio_server
from mcp.shared.exceptions import MCPError

Context = ServerRequestContext[Any, Any]
CONNECT_S = 5.0
PAUSE_S = 60.0
"""Between two words of a mission that is told; a tool call has no end of its own."""


async def serve(url: str, key: str) -> None:
    """Until stdin ends. Raises what the client raises where the coordinator is away, or refuses the key."""
    headers = {"Authorization": f"Bearer {key}"} if key else {}
    timeout = httpx2.Timeout(None, connect=CONNECT_S, write=PAUSE_S, pool=CONNECT_S)
    async with (
        httpx2.AsyncClient(headers=headers, timeout=timeout, trust_env=False) as http,
        Client(streamable_http_client(url, http_client=http), mode="legacy", cache=None) as client,
        stdio_server() as (reading, writing),
    ):
        server = passing_on_to(client)
        await server.run(reading, writing, server.create_initialization_options())


def passing_on_to(client: Client) -> Server[Any]:
    """A server that asks another one."""

    async def list_tools(_: Context, params: types.PaginatedRequestParams | None) -> types.ListToolsResult:
        return await client.list_tools(cursor=params.cursor if params is not None else None)

    async def call_tool(context: Context, params: types.CallToolRequestParams) -> types.CallToolResult:
        """Cancelled here, it is cancelled there."""
        return await client.call_tool(params.name, params.arguments, progress_callback=context.session.report_progress)

    async def list_resources(_: Context, params: types.PaginatedRequestParams | None) -> types.ListResourcesResult:
        return await client.list_resources(cursor=params.cursor if params is not None else None)

    async def read_resource(_: Context, params: types.ReadResourceRequestParams) -> types.ReadResourceResult:
        return await client.read_resource(str(params.uri))

    told = client.server_info
    return Server(
        told.name if told is not None else "atom",
        version=told.version if told is not None else "",
        instructions=client.instructions,
        on_list_tools=list_tools,
        on_call_tool=call_tool,
        on_list_resources=list_resources,
        on_read_resource=read_resource,
    )


def run(url: str, key: str) -> str:
    """Why the coordinator does not serve it; '' once stdin has ended."""
    why = ""
    try:
        anyio.run(serve, url, key)
    except* (httpx2.HTTPError, MCPError, OSError) as errors:
        why = "; ".join(str(error) or type(error).__name__ for error in _leaves(errors))
    return why


def _leaves(errors: BaseExceptionGroup[Exception]) -> list[BaseException]:
    return [
        leaf
        for error in errors.exceptions
        for leaf in (_leaves(error) if isinstance(error, BaseExceptionGroup) else [error])
    ]
