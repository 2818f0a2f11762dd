"""What somebody sends who means harm: each attack opens a connection of its own and tells what it was answered.

Told of a service: its port, a path that takes a JSON body, its WebSockets, and the header with a key (or none).
"""

import asyncio
import contextlib
import gzip
import os
import random
import socket
import struct
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Final

from bench.hostility.wire import connection, last_word, said

HOLD_S: Final = 3.0
BOMB: Final = gzip.compress(bytes(50_000_000))


@dataclass(frozen=True)
class Target:
    port: int
    post: str
    sockets: tuple[str, ...]
    header: str
    """`Authorization: ...\\r\\n`, or ''."""

    def head(self, *more: str, method: str = "POST", version: str = "1.1", host: str = "localhost") -> bytes:
        lines = "".join(f"{line}\r\n" for line in (f"Host: {host}", *more))
        return f"{method} {self.post} HTTP/{version}\r\n{lines}{self.header}".encode()

    def json(self, body: bytes, kind: str = "application/json", *more: str) -> bytes:
        return self.head(f"Content-Type: {kind}", f"Content-Length: {len(body)}", *more) + b"\r\n" + body


Attack = Callable[[Target, random.Random], Awaitable[str]]
BODIES: Final[tuple[bytes, ...]] = (
    b"{", b"", b"null", b"NaN", b"-Infinity", b'{"a": NaN}', b"[" * 100_000, b'{"a":' * 50_000, b"1" * 100_000,
    b'"\\ud800"', b'{"twist": 1, "twist": 2}', b"\xff\xfe\x00{", b"\xc3\x28", b"\x00" * 1000, b'{"epoch": 1e999}',
)  # fmt: skip


async def body(target: Target, chance: random.Random) -> str:
    return await said(target.port, target.json(chance.choice(BODIES)))


async def wrong_kind(target: Target, chance: random.Random) -> str:
    kinds = (
        "text/plain",
        "application/xml",
        "multipart/form-data",
        "multipart/form-data; boundary=x",
        "\xff",
        "a" * 999,
    )
    return await said(target.port, target.json(b'--x\r\n\r\n{"a": 1}', chance.choice(kinds)))


async def large(target: Target, chance: random.Random) -> str:
    return await said(target.port, target.json(b" " * 10_000_000))


async def gzip_bomb(target: Target, chance: random.Random) -> str:
    return await said(target.port, target.json(BOMB, "application/json", "Content-Encoding: gzip"))


async def endless_chunks(target: Target, chance: random.Random) -> str:
    async with connection(target.port) as (reader, writer):
        with contextlib.suppress(ConnectionError):
            writer.write(target.head("Content-Type: application/json", "Transfer-Encoding: chunked") + b"\r\n")
            for _ in range(300):
                writer.write(b"4000\r\n" + b" " * 0x4000 + b"\r\n")
                await writer.drain()
        return await last_word(reader)


async def broken_http(target: Target, chance: random.Random) -> str:
    path = target.post
    lines = (
        os.urandom(200) + b"\r\n\r\n",
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + os.urandom(200),
        f"POST {path} HTTP/1.1\r\nHost: x\r\nContent-Length: -5\r\n\r\n".encode(),
        f"POST {path} HTTP/1.1\r\nHost: x\r\nContent-Length: 5\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n".encode(),
        f"POST {path} HTTP/9.9\r\n\r\n".encode(),
        f"GET {path}\x00 HTTP/1.1\r\nHost: localhost\r\n\r\n".encode(),
        b"GET http://[::1 HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"GET /%ff%fe/../..//%00?%=&&==%zz HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
        b"CONNECT localhost:22 HTTP/1.1\r\nHost: localhost\r\n\r\n",
    )
    return await said(target.port, chance.choice(lines), end=True)


async def old_http(target: Target, chance: random.Random) -> str:
    return await said(target.port, target.head(method="GET", version="1.0") + b"\r\n")


async def giant_header(target: Target, chance: random.Random) -> str:
    return await said(target.port, target.head(f"X-Giant: {'a' * chance.choice((70_000, 2_000_000))}") + b"\r\n")


async def many_headers(target: Target, chance: random.Random) -> str:
    return await said(target.port, target.head(*(f"X-{number}: a" for number in range(5000))) + b"\r\n")


async def other_host(target: Target, chance: random.Random) -> str:
    host = chance.choice(("evil.example", "localhost.evil.example", "", "[::1", "a" * 300, "\xff"))
    return await said(target.port, target.head("Content-Length: 0", host=host) + b"\r\n")


async def other_origin(target: Target, chance: random.Random) -> str:
    origin = chance.choice(("http://evil.example", "null", "http://[", "file://", "http://localhost:1\x7f"))
    return await said(target.port, target.head(f"Origin: {origin}", "Content-Length: 0") + b"\r\n")


async def pipelined(target: Target, chance: random.Random) -> str:
    return await said(target.port, target.json(b"{}") * 20)


async def slow_head(target: Target, chance: random.Random) -> str:
    return await _slowly(target, target.head("X-Slow: " + "a" * 100))


async def slow_body(target: Target, chance: random.Random) -> str:
    return await _slowly(target, target.json(b" " * 100))


async def _slowly(target: Target, data: bytes) -> str:
    async with connection(target.port) as (reader, writer):
        with contextlib.suppress(ConnectionError):
            writer.write(data[:-20])
            for each in data[-20:-1]:
                writer.write(bytes([each]))
                await asyncio.sleep(HOLD_S / 20)
        reader.feed_eof()
    return "left"


async def half_open(target: Target, chance: random.Random) -> str:
    """Says half of it and goes, politely or by a reset."""
    async with connection(target.port) as (_, writer):
        data = target.json(b" " * 500)
        writer.write(data[: chance.randrange(len(data))])
        await asyncio.sleep(chance.uniform(0.0, 0.2))
        if chance.random() < 0.5:
            writer.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            writer.transport.abort()
    return "left"


async def silent(target: Target, chance: random.Random) -> str:
    async with connection(target.port):
        await asyncio.sleep(HOLD_S)
    return "left"


def _frame(opcode: int, payload: bytes) -> bytes:
    """Of a client, so masked (with zeros)."""
    length = bytes([0x80 | len(payload)]) if len(payload) < 126 else b"\xfe" + struct.pack(">H", len(payload))
    return bytes([0x80 | opcode]) + length + b"\0\0\0\0" + payload


FRAMES: Final[tuple[bytes, ...]] = (
    b"",
    b"\x81\xff" + struct.pack(">Q", 2**62) + b"\0\0\0\0",
    b"\x81\xff" + struct.pack(">Q", 5_000_000) + b"\0\0\0\0" + b"a" * 5_000_000,
    _frame(1, b"\xff\xfe"),
    _frame(1, b"{"),
    _frame(1, b"[" * 60_000),
    _frame(1, b'{"twist": {"linear_x": NaN}}'),
    _frame(2, bytes(1000)),
    _frame(1, b"next") * 200,
    _frame(8, b"\x00"),
    _frame(9, b"ping") * 100,
    _frame(3, b"reserved"),
    b"\x01\x80\0\0\0\0" * 1000,
)


async def web_socket(target: Target, chance: random.Random) -> str:
    """Opens one and sends garbage, a frame too large, or nothing; reads nothing."""
    if not target.sockets:
        return await body(target, chance)
    key = "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n"
    upgrade = f"Host: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n{key}{target.header}\r\n"
    async with connection(target.port) as (reader, writer):
        writer.write(f"GET {chance.choice(target.sockets)} HTTP/1.1\r\n{upgrade}".encode())
        status = (await reader.readuntil(b"\r\n\r\n")).split()[1].decode()
        with contextlib.suppress(ConnectionError):
            writer.write(chance.choice(FRAMES))
            await asyncio.sleep(chance.uniform(0.0, HOLD_S))
    return status


ATTACKS: Final[dict[str, tuple[float, Attack]]] = {
    "body": (30, body),
    "wrong_kind": (10, wrong_kind),
    "large": (1, large),
    "gzip_bomb": (2, gzip_bomb),
    "endless_chunks": (1, endless_chunks),
    "broken_http": (10, broken_http),
    "old_http": (5, old_http),
    "giant_header": (2, giant_header),
    "many_headers": (1, many_headers),
    "other_host": (5, other_host),
    "other_origin": (5, other_origin),
    "pipelined": (5, pipelined),
    "slow_head": (3, slow_head),
    "slow_body": (3, slow_body),
    "half_open": (10, half_open),
    "silent": (2, silent),
    "web_socket": (10, web_socket),
}
"""With their weights."""


async def attack(name: str, target: Target, chance: random.Random) -> str:
    """What it was answered, or in what the connection ended."""
    try:
        return await ATTACKS[name][1](target, chance)
    except (OSError, asyncio.IncompleteReadError):
        return "closed"
