"""The live view: what a recording would hold, over Foxglove's WebSocket protocol, to be looked at and no more.

On this machine's own address only: the protocol knows no keys. It offers no capability, so that a client can neither
publish, call a service, set a parameter nor fetch a file.
"""

import threading
import time
from collections import deque
from typing import Final

import foxglove
import structlog
from foxglove.websocket import ChannelView, Client, ServerListener, WebSocketServer

from mesh.errors import UnavailableError
from robot_bridge.ports import Kind, Raw

log = structlog.get_logger()

HOST: Final = "127.0.0.1"
WAITING_MAX: Final = 50
WAITING_BYTES_MAX: Final = 4_000_000
"""Of one topic on its way to the server; the oldest messages make room, the newest always waits: a few pictures."""
BACKLOG_MAX: Final = 32
"""Messages on their way to one client; the oldest make room. More than there are topics: a client is told of all of
them, and the newest of each, in one go. The SDK counts no bytes and no clients: who does not read costs 32 pictures."""
SAID_AGAIN_S: Final = (0.1, 1.0)
"""After a client subscribed: the SDK tells of it before the client is on the channel (foxglove-sdk, `on_subscribe` in
connected_client.rs), so that what is said at once may pass it by. Twice, because nothing says when it is."""
CLOSE_S_MAX: Final = 1.0
"""So long a close waits; the SDK's own waits for every client's farewell, and some never answer."""


class FoxgloveView(ServerListener):
    """Implements `ports.LiveView` with a thread of its own. Made by `open_foxglove`."""

    def __init__(self) -> None:
        self._context = foxglove.Context()
        self._channels: dict[tuple[str, Kind], foxglove.Channel] = {}
        self._changed = threading.Condition()
        self._waiting: dict[str, deque[Raw]] = {}
        self._newest: dict[str, Raw] = {}
        self._again: dict[tuple[str, float], float] = {}
        self._closing = False
        self._server: WebSocketServer | None = None
        self._thread = threading.Thread(target=self._forward, name="foxglove", daemon=True)

    def open(self, port: int) -> None:
        """Raises `OSError` where nobody may listen on the port."""
        try:
            self._server = foxglove.start_server(
                name="atom",
                host=HOST,
                port=port,
                capabilities=[],
                server_listener=self,
                context=self._context,
                message_backlog_size=BACKLOG_MAX,
            )
        except RuntimeError as error:  # what the SDK makes of every failure to listen
            raise OSError(str(error)) from error
        self._thread.start()

    @property
    def port(self) -> int:
        """Where it listens; 0 once it is closed."""
        return self._server.port if self._server is not None else 0

    def waiting(self, topic: str) -> tuple[Raw, ...]:
        """What is still to be handed to the server, the oldest first."""
        with self._changed:
            return tuple(self._waiting.get(topic, ()))

    def show(self, message: Raw) -> None:
        with self._changed:
            self._newest[message.topic] = message
            self._put(message)

    def on_subscribe(self, client: Client, channel: ChannelView) -> None:
        """What was said once (a map, a fixed frame) is said again for who comes late; in the SDK's thread."""
        now_s = time.monotonic()
        with self._changed:
            self._again |= {(channel.topic, delay_s): now_s + delay_s for delay_s in SAID_AGAIN_S}
            self._changed.notify()

    def close(self) -> None:
        """Listening no more, after `CLOSE_S_MAX` at most; a client that does not answer is left to a thread of its own,
        which the end of the process takes along."""
        with self._changed:
            self._closing = True
            self._changed.notify()
        if self._server is not None:
            stopping = threading.Thread(target=self._stop, args=(self._server,), name="foxglove-stop", daemon=True)
            stopping.start()
            stopping.join(CLOSE_S_MAX)
            if stopping.is_alive():
                log.warning("a client of the live view does not answer: it is not waited for")
            self._server = None

    def _stop(self, server: WebSocketServer) -> None:
        self._thread.join()
        server.stop()

    def _put(self, message: Raw) -> None:
        """Holding the lock."""
        waiting = self._waiting.get(message.topic)
        if waiting is None:
            waiting = self._waiting[message.topic] = deque(maxlen=WAITING_MAX)
        waiting.append(message)
        while len(waiting) > 1 and sum(len(each.data) for each in waiting) > WAITING_BYTES_MAX:
            waiting.popleft()
        self._changed.notify()

    def _say_again(self) -> bool:
        """Holding the lock: puts the newest of what is due; whether anything was."""
        now_s = time.monotonic()
        due = [each for each, due_s in self._again.items() if due_s <= now_s]
        for topic, delay_s in due:
            del self._again[topic, delay_s]
            if topic in self._newest:
                self._put(self._newest[topic])
        return bool(due)

    def _forward(self) -> None:
        while True:
            with self._changed:
                while not (self._closing or self._say_again() or any(self._waiting.values())):
                    soonest_s = min(self._again.values(), default=None)
                    self._changed.wait(None if soonest_s is None else max(0.0, soonest_s - time.monotonic()))
                if self._closing:
                    return
                batch = [message for waiting in self._waiting.values() for message in waiting]
                for waiting in self._waiting.values():
                    waiting.clear()
            for message in batch:
                self._channel(message).log(message.data, log_time=message.log_ns)

    def _channel(self, message: Raw) -> foxglove.Channel:
        """Advertised with its first message."""
        key = message.topic, message.kind
        if key not in self._channels:
            kind = message.kind
            schema = foxglove.Schema(name=kind.name, encoding=kind.schema_encoding, data=kind.definition)
            self._channels[key] = foxglove.Channel(
                message.topic, schema=schema, message_encoding=kind.message_encoding, context=self._context
            )
        return self._channels[key]


def open_foxglove(port: int) -> FoxgloveView:
    """Listening (0 = on any free port). Raises `UnavailableError` where it cannot."""
    view = FoxgloveView()
    try:
        view.open(port)
    except OSError as error:
        raise UnavailableError("foxglove", f"port {port}: {error}") from error
    log.info("a live view for Foxglove", address=f"ws://{HOST}:{view.port}")
    return view
