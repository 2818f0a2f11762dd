"""Caddy itself, as ops/caddy/Caddyfile has it, in front of an app with the services' own rules."""

import asyncio
import os
import ssl
import subprocess
import sys
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path

import httpx
import pytest
import websockets
from fastapi import FastAPI, Request, WebSocket

from mesh.middleware import SameOrigin
from support.redis_server import free_port
from support.served import served
from support.source import ROOT
from support.waiting import until, until_true

CADDY = Path(sys.executable).with_name("caddy")
SITE = "127.0.0.1"
"""An address, because that is the harder case: browsers name none in the TLS greeting."""


@dataclass(frozen=True)
class Front:
    """Where Caddy listens, and what to trust."""

    https: str
    http: str
    trusting: ssl.SSLContext


def page() -> FastAPI:
    app = FastAPI()
    app.add_middleware(SameOrigin)

    @app.post("/missions")
    async def start(request: Request) -> dict[str, str]:
        return {**request.headers}

    @app.websocket("/live")
    async def live(socket: WebSocket) -> None:
        await socket.accept()
        await socket.send_text(await socket.receive_text())

    return app


@pytest.fixture
async def front(tmp_path: Path) -> AsyncIterator[Front]:
    https, http = free_port(), free_port()
    async with served(page()) as behind:
        environment = os.environ | {
            "ATOM_SITE": SITE,
            "CADDY_HTTPS_PORT": str(https),
            "CADDY_HTTP_PORT": str(http),
            "CADDY_UI": behind.removeprefix("http://"),
            "CADDY_ADMIN": f"unix/{tmp_path}/admin.sock",
            "XDG_DATA_HOME": str(tmp_path),
            "XDG_CONFIG_HOME": str(tmp_path),
        }
        command = [CADDY, "run", "--config", ROOT / "ops/caddy/Caddyfile", "--adapter", "caddyfile"]
        caddy = await asyncio.create_subprocess_exec(*command, env=environment, stderr=subprocess.DEVNULL)
        root = tmp_path / "caddy/pki/authorities/local/root.crt"
        try:
            await until(root.is_file)
            trusting = ssl.create_default_context(cafile=str(root))
            async with httpx.AsyncClient(verify=trusting) as client:

                async def answers() -> bool:
                    try:
                        return (await client.get(f"https://{SITE}:{https}/nothing")).status_code == 404
                    except httpx.HTTPError:
                        return False

                await until_true(answers)
            yield Front(f"https://{SITE}:{https}", f"http://{SITE}:{http}", trusting)
        finally:
            caddy.terminate()
            await caddy.wait()


async def test_the_page_is_reached_by_https_and_only_by_it(front: Front) -> None:
    async with httpx.AsyncClient(verify=front.trusting) as client:
        plain = await client.post(f"{front.http}/missions")
        assert plain.status_code == 308
        assert plain.headers["location"].startswith("https://")
        said = {"Origin": front.https, "X-Forwarded-For": "8.8.8.8", "X-Forwarded-Host": "evil.example"}
        answer = await client.post(f"{front.https}/missions", headers=said)
        assert answer.status_code == 200
        seen = answer.json()
    assert (seen["x-forwarded-proto"], seen["x-forwarded-for"]) == ("https", "127.0.0.1")
    assert seen["x-forwarded-host"] == seen["host"] == front.https.removeprefix("https://")


async def test_a_foreign_page_is_refused_behind_it_too(front: Front) -> None:
    said = {"Origin": "https://evil.example", "X-Forwarded-Host": "evil.example"}
    async with httpx.AsyncClient(verify=front.trusting) as client:
        assert (await client.post(f"{front.https}/missions", headers=said)).status_code == 403


async def test_sockets_pass_it(front: Front) -> None:
    place = front.https.replace("https", "wss")
    async with websockets.connect(f"{place}/live", ssl=front.trusting, origin=front.https) as socket:  # pyright: ignore[reportArgumentType]
        await socket.send("here")
        assert await socket.recv() == "here"


async def test_whoever_does_not_trust_its_authority_is_warned(front: Front) -> None:
    async with httpx.AsyncClient() as client:
        with pytest.raises(httpx.ConnectError, match="CERTIFICATE_VERIFY_FAILED"):
            await client.get(front.https)
