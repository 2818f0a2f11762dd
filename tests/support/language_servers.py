"""Stand-ins for language-model servers: one speaks Ollama's wire format, one OpenAI's; each in several moods."""

import contextlib
import json
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

WHOLE_BODY = "whole body"


@dataclass(frozen=True)
class Reply:
    """A message as it goes over the wire, and why it ended; `WHOLE_BODY` where it is all that is sent."""

    message: dict[str, Any]
    ending: str = "stop"

    @classmethod
    def of(cls, content: "str | Reply") -> "Reply":
        return content if isinstance(content, Reply) else cls({"content": content})


class LanguageServer(ThreadingHTTPServer):
    """Answers in one of its moods with the next of `contents`, the last for ever; remembers what it was asked."""

    daemon_threads = True

    def __init__(self, handler: type["_Handler"]) -> None:
        super().__init__(("127.0.0.1", 0), handler)
        self.mood = "valid"
        self.contents: list[str | Reply] = []
        self.asked: list[dict[str, Any]] = []
        self.headers_seen: list[dict[str, str]] = []
        self.refuses_named_format = False
        self.refuses_think = False
        self.refuses_tools = False
        self.may_answer = threading.Event()
        self.raw: tuple[int, bytes, dict[str, str]] = (200, b"", {})
        """Status, body and headers in the mood `as_it_is`."""

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server_port}"

    def says(self, *contents: object) -> None:
        """Texts, objects that are the JSON in a text, or what `Reply` says of a whole message."""
        self.contents = [one if isinstance(one, str | Reply) else json.dumps(one) for one in contents]

    def content(self) -> "str | Reply":
        return self.contents.pop(0) if len(self.contents) > 1 else self.contents[0]


class _Handler(BaseHTTPRequestHandler):
    server: LanguageServer
    protocol_version = "HTTP/1.1"
    path_wanted = ""

    def log_message(self, format: str, *args: Any) -> None:
        return

    def do_POST(self) -> None:
        body = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        self.server.asked.append(body)
        self.server.headers_seen.append({key.lower(): value for key, value in self.headers.items()})
        with contextlib.suppress(BrokenPipeError, ConnectionResetError):
            if self.path != self.path_wanted:
                self.send(404, {"error": f"no route {self.path}"})
            else:
                getattr(self, self.server.mood)(body)

    def valid(self, body: dict[str, Any]) -> None:
        said = Reply.of(self.server.content())
        self.send(200, said.message if said.ending == WHOLE_BODY else self.reply(body, said))

    def slow(self, body: dict[str, Any]) -> None:
        """Answers well, but only when told to."""
        self.server.may_answer.wait(30.0)
        self.valid(body)

    def hangs(self, body: dict[str, Any]) -> None:
        """Sends its headers and then nothing more."""
        self.send_response(200)
        self.send_header("Content-Length", "5000")
        self.end_headers()
        self.wfile.flush()
        self.server.may_answer.wait(30.0)
        self.close_connection = True

    def as_it_is(self, body: dict[str, Any]) -> None:
        status, raw, headers = self.server.raw
        self.send_response(status)
        for key, value in {"Content-Type": "application/json", "Content-Length": str(len(raw)), **headers}.items():
            self.send_header(key, value)
        self.end_headers()
        self.wfile.write(raw)

    def malformed(self, body: dict[str, Any]) -> None:
        self.send(200, b'{"model": "x", "message": {"role": ')

    def not_a_reply(self, body: dict[str, Any]) -> None:
        self.send(200, {"message": 5, "choices": 5})

    def overloaded(self, body: dict[str, Any]) -> None:
        self.send(503, self.problem("server busy"))

    def missing(self, body: dict[str, Any]) -> None:
        self.send(404, self.problem(f"model '{body['model']}' not found"))

    def floods(self, body: dict[str, Any]) -> None:
        """One answer that never ends."""
        self.send_response(200)
        self.send_header("Content-Length", str(10**12))
        self.end_headers()
        self.wfile.write(b'{"message": {"role": "assistant", "content": "')
        while not self.server.may_answer.is_set():
            self.wfile.write(b"go on " * 10_000)

    def dies_mid_answer(self, body: dict[str, Any]) -> None:
        self.send_response(200)
        self.send_header("Content-Length", "5000")
        self.end_headers()
        self.wfile.write(b'{"model"')
        self.wfile.flush()
        self.close_connection = True

    def reply(self, body: dict[str, Any], said: Reply) -> dict[str, Any]:
        raise NotImplementedError

    def problem(self, message: str) -> dict[str, Any]:
        raise NotImplementedError

    def send(self, status: int, data: bytes | dict[str, Any]) -> None:
        raw = data if isinstance(data, bytes) else json.dumps(data).encode()
        self.send_response(status)
        self.send_header("Content-Type", "application/json; charset=utf-8")
        self.send_header("Content-Length", str(len(raw)))
        self.end_headers()
        self.wfile.write(raw)


class OllamaHandler(_Handler):
    path_wanted = "/api/chat"

    def valid(self, body: dict[str, Any]) -> None:
        if self.server.refuses_think and "think" in body:
            self.send(400, self.problem("invalid think value"))
        elif self.server.refuses_tools and body.get("tools"):
            self.send(400, self.problem(f"{body['model']} does not support tools"))
        else:
            super().valid(body)

    def reply(self, body: dict[str, Any], said: Reply) -> dict[str, Any]:
        return {
            "model": body["model"],
            "created_at": "2026-01-01T00:00:00.000000Z",
            "message": {"role": "assistant", "content": ""} | said.message,
            "done": True,
            "done_reason": said.ending,
            "total_duration": 5_000_000_000,
            "eval_count": 20,
        }

    def problem(self, message: str) -> dict[str, Any]:
        return {"error": message}


class OpenAiHandler(_Handler):
    path_wanted = "/v1/chat/completions"

    def valid(self, body: dict[str, Any]) -> None:
        if self.server.refuses_think and "chat_template_kwargs" in body:
            self.send(400, self.problem("Unrecognized request argument supplied: chat_template_kwargs"))
        elif self.server.refuses_named_format and body["response_format"]["type"] != "json_object":
            self.send(500, self.problem("response_format.type: Input should be 'text' or 'json_object'"))
        else:
            super().valid(body)

    def reply(self, body: dict[str, Any], said: Reply) -> dict[str, Any]:
        message = {"role": "assistant", "content": None} | said.message
        return {
            "id": "chatcmpl-1",
            "object": "chat.completion",
            "created": 1_767_225_600,
            "model": body["model"],
            "choices": [{"index": 0, "message": message, "finish_reason": said.ending, "logprobs": None}],
            "usage": {"prompt_tokens": 90, "completion_tokens": 20, "total_tokens": 110},
        }

    def problem(self, message: str) -> dict[str, Any]:
        return {"error": {"message": message, "type": "invalid_request_error", "param": None, "code": None}}


@contextlib.contextmanager
def running(handler: type[_Handler]) -> Iterator[LanguageServer]:
    """Serves on a free port of the loopback until the block ends, whatever mood it hangs in."""
    with LanguageServer(handler) as server:
        thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02})
        thread.start()
        try:
            yield server
        finally:
            server.may_answer.set()
            server.shutdown()
            thread.join(30.0)
