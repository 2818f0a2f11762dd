"""Which pages may ask for what moves the robot."""

from collections.abc import AsyncIterator

import httpx
import pytest
from fastapi import FastAPI

from mesh.middleware import SameOrigin


@pytest.fixture
async def client() -> AsyncIterator[httpx.AsyncClient]:
    app = FastAPI()
    app.add_middleware(SameOrigin, open_paths={"/stop"})
    for path in ("/go", "/stop"):
        app.post(path)(lambda: {"ok": True})
    async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://10.0.0.7:8080") as opened:
        yield opened


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({}, 200),
        ({"origin": "http://10.0.0.7:8080"}, 200),
        ({"origin": "http://evil.example"}, 403),
        ({"origin": "null"}, 403),
        ({"origin": "null", "x-forwarded-host": ""}, 403),
        ({"origin": "https://home.example", "x-forwarded-host": "home.example"}, 200),
        ({"origin": "https://home.example", "x-forwarded-host": "home.example, 10.0.0.7"}, 200),
        ({"origin": "https://evil.example", "x-forwarded-host": "home.example"}, 403),
        ({"origin": "https://evil.example", "x-forwarded-host": "home.example, evil.example"}, 403),
    ],
)
async def test_the_place_the_browser_asked_for_is_the_hosts_or_the_proxys(
    client: httpx.AsyncClient, headers: dict[str, str], status: int
) -> None:
    assert (await client.post("/go", headers=headers)).status_code == status
    assert (await client.post("/stop", headers=headers)).status_code == 200


async def test_no_page_may_send_the_proxys_header_itself(client: httpx.AsyncClient) -> None:
    """A browser asks first (CORS), and is not told yes."""
    asked = {
        "origin": "http://evil.example",
        "access-control-request-method": "POST",
        "access-control-request-headers": "x-forwarded-host",
    }
    answer = await client.options("/go", headers=asked)
    assert "access-control-allow-origin" not in answer.headers
