"""Runs a service's app under uvicorn, ending cleanly on SIGINT and SIGTERM."""

import asyncio
import contextlib
import signal
import socket
import sys
from types import FrameType
from typing import Any, Final

import uvicorn
from fastapi import FastAPI
from starlette.types import ASGIApp
from uvicorn.config import STARTUP_FAILURE
from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol, RequestResponseCycle
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

HEADER_BYTES_MAX: Final = 64 * 1024
HEADER_S_MAX = 10.0
BODY_WAIT_S_MAX = 20.0
ANSWER_WAIT_S_MAX = 30.0
"""A part of an answer waits in memory; a reader of whom nothing is heard for so long gets no more of it."""
TIMED_OUT: Final = b"HTTP/1.1 408 Request Timeout\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"
NO_HANDSHAKE: Final = b"HTTP/1.1 400 Bad Request\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"
TOO_LARGE: Final = b"HTTP/1.1 431 Request Header Fields Too Large\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"


class RequestLimitsProtocol(HttpToolsProtocol):
    """uvicorn's own waits for the end of a request for ever, and keeps all that comes of its headers.

    Here a connection is closed that has not ended its headers `HEADER_S_MAX` after it was made, or after its last
    answer; 431 answers what has sent `HEADER_BYTES_MAX` without an end (and what one read brings beyond that), 408 a
    body of which nothing came for `BODY_WAIT_S_MAX`. Whoever takes nothing of what waits for him of an answer for
    `ANSWER_WAIT_S_MAX` is let go (after twice as long at most): what the answer is made of (a file, a picture, a
    place in a queue) is held for him.
    What comes between parts of a chunked body and behind its last (extensions, trailers) is bound by the same number of
    bytes, and belongs to no header: an app would see trailers among those its access was decided by. Every request that
    waits on a connection which closes is told so: uvicorn tells the last one read, and what writes for the others gets
    a RuntimeError of uvloop.
    """

    _bytes = 0
    """Of headers, since the last message ended; of what is no body, since the last part of one."""
    _read = 0
    _in_body = False
    _deadline: asyncio.TimerHandle | None = None
    """Of the headers."""
    _untaken = 0
    """Bytes of an answer that waited for its reader when they were last looked at."""
    _body_deadline: asyncio.TimerHandle | None = None
    _answer_deadline: asyncio.TimerHandle | None = None

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._answering = list[RequestResponseCycle]()
        """The requests read and not answered yet: the one that is being answered, then those pipelined behind it."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # pyright: ignore[reportIncompatibleMethodOverride]
        super().connection_made(transport)
        self._expect_headers()

    def connection_lost(self, exc: Exception | None) -> None:
        self._unset_deadline()
        self._unset_body_deadline()
        self._unset_answer_deadline()
        super().connection_lost(exc)
        self._tell_answering()

    def data_received(self, data: bytes) -> None:
        self._read = len(data)
        super().data_received(data)
        if self.transport.is_closing():  # what came is not HTTP
            self._close()
        if self._in_body:
            self._expect_body()
        self._bytes += len(data)
        if self._bytes > HEADER_BYTES_MAX and not self.transport.is_closing():
            if self._deadline is not None:  # else an answer is under way
                self.transport.write(TOO_LARGE)
            self._close()

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
        before: object = self.cycle
        super().on_headers_complete()
        if self.cycle is not before:  # else it asked for another protocol
            self._answering.append(self.cycle)

    def on_message_complete(self) -> None:
        super().on_message_complete()
        self._in_body = False
        self._unset_body_deadline()
        self._bytes = -self._read  # what was read with the end of this one counts for nothing

    def on_response_complete(self) -> None:
        self._answering = [one for one in self._answering if not one.response_complete]
        super().on_response_complete()
        if self.timeout_keep_alive_task is not None:  # nothing more to answer
            self._expect_headers()

    def pause_writing(self) -> None:
        super().pause_writing()
        self._expect_reader()

    def resume_writing(self) -> None:
        self._unset_answer_deadline()
        super().resume_writing()

    def _expect_headers(self) -> None:
        self._unset_deadline()
        self._deadline = self.loop.call_later(HEADER_S_MAX, self._close)

    def _expect_body(self) -> None:
        self._unset_body_deadline()
        self._body_deadline = self.loop.call_later(BODY_WAIT_S_MAX, self._give_up_body)

    def _expect_reader(self) -> None:
        self._unset_answer_deadline()
        self._untaken = self.transport.get_write_buffer_size()
        self._answer_deadline = self.loop.call_later(ANSWER_WAIT_S_MAX, self._give_up_reader)

    def _give_up_reader(self) -> None:
        if self.transport.get_write_buffer_size() < self._untaken:
            self._expect_reader()
        else:
            self.transport.abort()

    def _give_up_body(self) -> None:
        if self.flow.read_paused:  # it is the service that has not read what came
            self._expect_body()
            return
        begun = any(one.response_started for one in self._answering)
        if self._answering and not begun and not self.transport.is_closing():
            self.transport.write(TIMED_OUT)
        self._close()

    def _close(self) -> None:
        self.transport.close()
        self._tell_answering()

    def _tell_answering(self) -> None:
        for cycle in self._answering:
            cycle.disconnected = True
            cycle.message_event.set()

    def _unset_deadline(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None

    def _unset_body_deadline(self) -> None:
        if self._body_deadline is not None:
            self._body_deadline.cancel()
            self._body_deadline = None

    def _unset_answer_deadline(self) -> None:
        if self._answer_deadline is not None:
            self._answer_deadline.cancel()
            self._answer_deadline = None


class WebSocketLimitsProtocol(WebSocketsSansIOProtocol):
    """Answers an upgrade that is no WebSocket handshake (a body, too many headers) with 400: uvicorn's own keeps it for
    ever without an answer, and cannot shut down beside it. Closes with 1007 what sends text that is no UTF-8, as
    uvicorn's own does, but for the traceback it logs each.
    """

    def data_received(self, data: bytes) -> None:
        super().data_received(data)
        if not self.handshake_initiated and not self.transport.is_closing():  # the whole head came in one piece
            self.close_sent = True
            self.transport.write(NO_HANDSHAKE)
            self.transport.close()

    def send_receive_event_to_app(self) -> None:
        if self.curr_msg_data_type == "text" and not self.close_sent:
            try:
                b"".join(self.frames).decode()
            except UnicodeDecodeError:
                self.frames = []
                self.conn.send_close(1007)
                self.handle_parser_exception()
                return
        super().send_receive_event_to_app()


class DrainingServer(uvicorn.Server):
    """Tells its app that it ends (`mesh.app.is_ending`) before it cuts anything off."""

    def __init__(self, config: uvicorn.Config, app: FastAPI | ASGIApp) -> None:
        super().__init__(config)
        self._app = app

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        if isinstance(self._app, FastAPI):
            self._app.state.ending = True
        await super().shutdown(sockets)


def serve(app: FastAPI, *, host: str, port: int) -> None:
    """Blocks until the process is told to stop; open streams get two seconds to end. `host`: several, with commas.

    SIGTERM ends the process with 0 then: uvicorn raises it once more when it has drained, which by itself would end the
    process as if it had been killed, before what comes after this call.
    """
    signal.signal(signal.SIGTERM, _end)
    hosts: Any = host.split(",")  # uvicorn's type says one; asyncio's create_server, which it hands it to, takes more
    config = uvicorn.Config(
        app,
        host=hosts,
        port=port,
        http=RequestLimitsProtocol,
        ws=WebSocketLimitsProtocol,
        log_level="warning",
        access_log=False,
        timeout_graceful_shutdown=2,
    )
    server = DrainingServer(config, app)
    with contextlib.suppress(KeyboardInterrupt):
        server.run()
    if not server.started:
        sys.exit(STARTUP_FAILURE)


def _end(number: int, frame: FrameType | None) -> None:
    sys.exit(0)
