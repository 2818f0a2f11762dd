"""HTTP by hand: what no client library would send, and whatever is answered."""

import asyncio
import contextlib
from collections.abc import AsyncGenerator, Mapping
from typing import Final

from bench.hostility.drawing import Request

ANSWER_S_MAX: Final = 60.0
BODY_BYTES_MAX: Final = 1 << 16
"""Of an answer that has no end, so much is read."""


def encoded(request: Request, host: str, more: Mapping[str, str]) -> bytes:
    """The request as HTTP/1.1 with its length."""
    headers = {"Host": host, "Content-Length": str(len(request.body)), **request.headers, **more}
    lines = [f"{request.method} {request.path} HTTP/1.1", *(f"{name}: {value}" for name, value in headers.items())]
    return "\r\n".join([*lines, "", ""]).encode("utf-8", "replace") + request.body


async def answer(reader: asyncio.StreamReader, method: str) -> tuple[str, bool]:
    """The status of one answer, and whether the connection can be asked again."""
    head = (await reader.readuntil(b"\r\n\r\n")).lower()
    lines = head.split(b"\r\n")
    status = lines[0].split()[1].decode()
    headers = {name: value for name, _, value in (line.partition(b":") for line in lines[1:] if line)}
    if method == "HEAD" or status in {"204", "304"}:
        return status, b"close" not in headers.get(b"connection", b"")
    length = headers.get(b"content-length")
    if length is None or int(length) > BODY_BYTES_MAX:
        await reader.read(BODY_BYTES_MAX)
        return status, False
    await reader.readexactly(int(length))
    return status, b"close" not in headers.get(b"connection", b"")


@contextlib.asynccontextmanager
async def connection(port: int) -> AsyncGenerator[tuple[asyncio.StreamReader, asyncio.StreamWriter]]:
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    try:
        yield reader, writer
    finally:
        writer.close()


async def said(port: int, data: bytes, *, end: bool = False) -> str:
    """The status that raw bytes are answered with; `closed` where none is."""
    async with connection(port) as (reader, writer):
        with contextlib.suppress(ConnectionError):
            writer.write(data)
            await writer.drain()
            if end:
                writer.write_eof()
        return await last_word(reader)


async def last_word(reader: asyncio.StreamReader) -> str:
    try:
        async with asyncio.timeout(ANSWER_S_MAX):
            return (await answer(reader, "GET"))[0]
    except (asyncio.IncompleteReadError, ConnectionError):
        return "closed"
    except TimeoutError:
        return "silent"
