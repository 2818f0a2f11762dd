"""Viewers without a screen: each speaks to the ui as an open page does (NiceGUI's socket, camera, map marks).

Where there are keys, ATOM_KEY is theirs.
"""

import argparse
import asyncio
import contextlib
import os
import re
import signal
import sys
import uuid

import httpx
import socketio
from websockets.asyncio.client import connect
from websockets.exceptions import WebSocketException

CLIENT_ID = re.compile(r"[\"']client_id[\"']\s*:\s*[\"']([0-9a-f-]{36})[\"']")


def headers() -> dict[str, str]:
    return {"Authorization": f"Bearer {key}"} if (key := os.environ.get("ATOM_KEY")) else {}


async def page(url: str) -> socketio.AsyncClient:
    """The page's own connection, its handshake done; its timers run from here on."""
    async with httpx.AsyncClient(trust_env=False, timeout=30.0, headers=headers()) as http:
        text = (await http.get(url)).text
    found = CLIENT_ID.search(text)
    if found is None:
        raise RuntimeError("the page names no client")
    query = f"client_id={found[1]}&tab_id={uuid.uuid4()}&document_id={uuid.uuid4()}&next_message_id=0"
    client = socketio.AsyncClient()
    await client.connect(
        f"{url}?{query}&implicit_handshake=true",
        headers=headers(),
        socketio_path="/_nicegui_ws/socket.io",
        transports=["websocket"],
    )
    return client


async def pull(url: str, path: str, counts: dict[str, int]) -> None:
    """Asks for the next when the last has come, as the page's scripts do."""
    address = url.replace("http", "ws", 1) + path
    with contextlib.suppress(WebSocketException):
        async with connect(address, additional_headers=headers(), proxy=None, max_size=None) as socket:
            while True:
                await socket.send("next")
                if isinstance(await socket.recv(), bytes):
                    counts["frames"] += 1


async def view(url: str, viewers: int) -> None:
    counts = {"frames": 0}
    pages = [await page(url) for _ in range(viewers)]
    pulls = [asyncio.create_task(pull(url, f"/live/{what}", counts)) for what in ("camera", "scene") for _ in pages]
    ended = asyncio.Event()
    asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, ended.set)
    sys.stdout.write("watching\n")
    sys.stdout.flush()
    began_s = asyncio.get_running_loop().time()
    await ended.wait()
    seconds = asyncio.get_running_loop().time() - began_s
    for task in pulls:
        task.cancel()
    await asyncio.gather(*pulls, *(one.disconnect() for one in pages), return_exceptions=True)
    sys.stdout.write(f"{counts['frames'] / viewers / seconds:.2f}\n")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--url", required=True)
    parser.add_argument("--viewers", type=int, required=True)
    arguments = parser.parse_args()
    asyncio.run(view(arguments.url, arguments.viewers))
