"""One MCAP file and the thread that writes it: messages come from any thread, are never waited for, and are counted."""

import contextlib
import json
import queue
import threading
import time
from collections import Counter
from pathlib import Path

from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap.writer import CompressionType, Writer
from pydantic import BaseModel

from robot_bridge.ports import Kind, Raw

WAITING_MAX = 300
"""Messages on their way to the disk; more are dropped and counted."""
CHUNK_BYTES = 256 * 1024
FLUSH_PERIOD_S = 1.0
"""What a bridge that is killed may lose of a recording."""
LIBRARY = "atom robot_bridge"


def json_kind(message: type[BaseModel]) -> Kind:
    """JSON, read by its JSON Schema."""
    schema = json.dumps(message.model_json_schema()).encode()
    return Kind(message.__name__, MessageEncoding.JSON, SchemaEncoding.JSONSchema, schema)


class McapFile:
    """Open from the beginning; `put` until `finish`, or until a limit or the disk ends it (`ended_by` says which)."""

    def __init__(self, path: Path, *, bytes_max: int) -> None:
        """Raises `OSError` where the file cannot be made."""
        self.path = path
        self.ended_by = ""
        self.dropped = 0
        self.size_bytes = 0
        self._bytes_max = bytes_max
        self._counts: Counter[str] = Counter()
        self._waiting: queue.Queue[Raw | None] = queue.Queue(WAITING_MAX)
        self._stream = path.open("wb")
        self._flush_due_s = time.monotonic() + FLUSH_PERIOD_S
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._write, name="mcap", daemon=True)
        self._thread.start()

    @property
    def counts(self) -> dict[str, int]:
        """Messages written, by topic."""
        return dict(sorted(self._counts.copy().items()))

    @property
    def ended(self) -> bool:
        return self._ended.is_set()

    def put(self, message: Raw) -> None:
        """From any thread. After the end nothing happens."""
        if self._ended.is_set():
            return
        try:
            self._waiting.put_nowait(message)
        except queue.Full:
            self.dropped += 1

    def finish(self, reason: str, *, timeout_s: float = 30.0) -> None:
        """Writes what waits, closes the file, and waits for that. Blocks: not for the event loop."""
        deadline_s = time.monotonic() + timeout_s
        if not self.ended_by:
            self.ended_by = reason
        while self._thread.is_alive():  # it may be past its last look at a queue that is full
            try:
                self._waiting.put(None, timeout=0.1)
                break
            except queue.Full:
                if time.monotonic() > deadline_s:
                    return
        self._thread.join(max(0.0, deadline_s - time.monotonic()))

    def _write(self) -> None:
        try:
            with self._stream:
                writer = Writer(self._stream, chunk_size=CHUNK_BYTES, compression=CompressionType.ZSTD)
                writer.start(profile="ros2", library=LIBRARY)
                self._write_messages(writer)
                writer.finish()
                self.size_bytes = self._stream.tell()
        except OSError as error:
            self.ended_by = f"it could not be written: {error.strerror or error}"
        finally:
            self._ended.set()

    def _next(self, writer: Writer) -> Raw | None:
        """The next message, none after the last; what was written before is on its way to the disk every second."""
        while True:
            if time.monotonic() >= self._flush_due_s:
                self._flush_due_s = time.monotonic() + FLUSH_PERIOD_S
                if self._counts:
                    writer.flush()
                    self.size_bytes = self._stream.tell()
            with contextlib.suppress(queue.Empty):
                return self._waiting.get(timeout=max(0.0, self._flush_due_s - time.monotonic()))

    def _write_messages(self, writer: Writer) -> None:
        schemas: dict[Kind, int] = {}
        channels: dict[str, int] = {}
        unchunked = 0
        while (message := self._next(writer)) is not None:
            kind = message.kind
            if kind not in schemas:
                schemas[kind] = writer.register_schema(kind.name, kind.schema_encoding, kind.definition)
            if message.topic not in channels:
                channels[message.topic] = writer.register_channel(message.topic, kind.message_encoding, schemas[kind])
            writer.add_message(channels[message.topic], message.log_ns, message.data, message.log_ns)
            self._counts[message.topic] += 1
            written = self._stream.tell()
            unchunked = unchunked + len(message.data) if written == self.size_bytes else 0
            self.size_bytes = written
            if written + unchunked > self._bytes_max:
                self.ended_by = "size limit"
                return
