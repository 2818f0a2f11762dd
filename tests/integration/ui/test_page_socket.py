"""NiceGUI's socket, sent what is no engine.io packet."""

import asyncio
import logging

import pytest
from starlette.types import Message, Receive, Scope, Send
from websockets.asyncio.client import connect

from ui.page_socket import PageSocketErrors

from .conftest import Site

PATH = "/_nicegui_ws/socket.io/?EIO=4&transport=websocket"


@pytest.mark.asyncio(loop_scope="module")
async def test_what_is_no_packet_ends_the_socket_and_is_no_error_of_ours(
    site: Site, caplog: pytest.LogCaptureFixture
) -> None:
    for garbage in ("{", "[1]", "x" * 2000):
        async with connect(site.url.replace("http", "ws", 1) + PATH, proxy=None) as socket:
            await socket.send(garbage)
            await asyncio.wait_for(socket.wait_closed(), 30.0)
            assert socket.close_code == 1003
    assert [record.message for record in caplog.records if record.levelno >= logging.ERROR] == []


async def test_a_mistake_behind_the_socket_is_not_taken_for_a_strangers_packet() -> None:
    async def mistaken(scope: Scope, receive: Receive, send: Send) -> None:
        raise ValueError("of ours")

    async def receive() -> Message:
        return {"type": "websocket.connect"}

    async def send(_: Message) -> None:
        pass

    with pytest.raises(ValueError, match="of ours"):
        await PageSocketErrors(mistaken)({"type": "websocket", "path": PATH}, receive, send)
