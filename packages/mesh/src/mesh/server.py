"""Runs a service's app under uvicorn, ending cleanly on SIGINT and SIGTERM."""

import asyncio
import signal
import sys
from types import FrameType
from typing import Any, Final

import uvicorn
from fastapi import FastAPI
from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

HEADER_BYTES_MAX: Final = 64 * 1024
HEADER_S_MAX = 10.0
TOO_LARGE: Final = b"HTTP/1.1 431 Request Header Fields Too Large\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"


class HeaderLimitsProtocol(HttpToolsProtocol):
    """uvicorn's own waits for the end of a request's headers for ever, and keeps all that comes of them.

    Here a connection is closed that has not ended them `HEADER_S_MAX` after it was made, or after its last answer; 431
    answers what has sent `HEADER_BYTES_MAX` without an end (and what one read brings beyond that). Bodies do not count.
    What comes between parts of a chunked body and behind its last (extensions, trailers) is bound by the same number of
    bytes, and belongs to no header: an app would see trailers among those its access was decided by.
    """

    _bytes = 0
    """Of headers, since the last message ended; of what is no body, since the last part of one."""
    _read = 0
    _in_body = False
    _deadline: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # pyright: ignore[reportIncompatibleMethodOverride]
        super().connection_made(transport)
        self._expect_headers()

    def connection_lost(self, exc: Exception | None) -> None:
        self._unset_deadline()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        self._read = len(data)
        super().data_received(data)
        self._bytes += len(data)
        if self._bytes > HEADER_BYTES_MAX and not self.transport.is_closing():
            if self._deadline is not None:  # else an answer is under way
                self.transport.write(TOO_LARGE)
            self.transport.close()

    def on_header(self, name: bytes, value: bytes) -> None:
        if not self._in_body:
            super().on_header(name, value)

    def on_body(self, body: bytes) -> None:
        super().on_body(body)
        self._bytes = -self._read

    def on_headers_complete(self) -> None:
        self._unset_deadline()
        self._in_body = True
        self._bytes = -self._read
        super().on_headers_complete()

    def on_message_complete(self) -> None:
        super().on_message_complete()
        self._in_body = False
        self._bytes = -self._read  # what was read with the end of this one counts for nothing

    def on_response_complete(self) -> None:
        super().on_response_complete()
        if self.timeout_keep_alive_task is not None:  # nothing more to answer
            self._expect_headers()

    def _expect_headers(self) -> None:
        self._unset_deadline()
        self._deadline = self.loop.call_later(HEADER_S_MAX, self.transport.close)

    def _unset_deadline(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None


def serve(app: FastAPI, *, host: str, port: int) -> None:
    """Blocks until the process is told to stop; open streams get two seconds to end. `host`: several, with commas.

    SIGTERM ends the process with 0 then: uvicorn raises it once more when it has drained, which by itself would end the
    process as if it had been killed, before what comes after this call.
    """
    signal.signal(signal.SIGTERM, _end)
    hosts: Any = host.split(",")  # uvicorn's type says one; asyncio's create_server, which it hands it to, takes more
    uvicorn.run(
        app,
        host=hosts,
        port=port,
        http=HeaderLimitsProtocol,
        log_level="warning",
        access_log=False,
        timeout_graceful_shutdown=2,
    )


def _end(number: int, frame: FrameType | None) -> None:
    sys.exit(0)
