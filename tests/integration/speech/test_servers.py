"""Recognisers and voices that run elsewhere, asked over real sockets: what they are sent, and what is said of them."""

import contextlib
import json
import os
import socket
import socketserver
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from email.parser import BytesParser
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import numpy as np
import pytest

from mesh.errors import UnavailableError
from speech.adapters.openai_compatible import OpenAiRecognizer
from speech.adapters.piper import PiperSynthesizer
from speech.adapters.wyoming import WyomingRecognizer, WyomingSynthesizer

SECOND = np.full(16_000, 0.1, np.float32)


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return server.getsockname()[1]


@contextlib.contextmanager
def wyoming(manner: str = "") -> Iterator[str]:
    port = free_port()
    command = [sys.executable, "-m", "support.wyoming_server", str(port), manner]
    paths = {"PYTHONPATH": str(Path(__file__).parents[2])}
    process = subprocess.Popen(command, env=os.environ | paths)
    try:
        ready_by_s = time.monotonic() + 30.0
        while True:
            with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), 1.0):
                break
            assert time.monotonic() < ready_by_s, "the Wyoming server is not ready"
        yield f"tcp://127.0.0.1:{port}"
    finally:
        process.terminate()
        process.wait(10.0)


def test_a_wyoming_server_hears_the_sound_and_what_to_expect() -> None:
    with wyoming() as uri:
        recognizer = WyomingRecognizer(uri, language="en", timeout_s=10.0)
        recognizer.load()
        readings = [one.text for one in recognizer.readings(SECOND, ("", "cup, tea pot"))]
    assert (readings, recognizer.name) == (["32000 bytes", "32000 bytes cup tea pot"], "wyoming counter")


def test_a_wyoming_server_speaks() -> None:
    with wyoming() as uri:
        synthesizer = WyomingSynthesizer(uri, timeout_s=10.0)
        synthesizer.load()
        said = synthesizer.speak("I found it.", "constant", 1.0)
    assert [one.name for one in synthesizer.voices] == ["constant"]
    assert (len(said.samples), said.rate_hz, float(said.samples[0])) == (22_050, 22_050, 0.5)


@pytest.mark.parametrize(
    ("manner", "why"), [("mute", "does not answer in time"), ("rude", "hung up"), ("odd", "does not speak Wyoming")]
)
def test_a_wyoming_server_that_does_not_answer_is_told_as_away(manner: str, why: str) -> None:
    with wyoming(manner) as uri, pytest.raises(UnavailableError, match=why):
        next(WyomingRecognizer(uri, language="en", timeout_s=1.0).readings(SECOND, ("",)))


@contextlib.contextmanager
def answering(answer: bytes) -> Iterator[str]:
    """Says the same to whoever asks, and hangs up."""

    class Asked(socketserver.StreamRequestHandler):
        def handle(self) -> None:
            self.rfile.readline()
            self.wfile.write(answer)

    with socketserver.ThreadingTCPServer(("127.0.0.1", 0), Asked) as server:
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()
        yield f"tcp://127.0.0.1:{server.server_address[1]}"
        server.shutdown()
        thread.join(10.0)


NAMELESS = b'{"name": 5, "attribution": {"name": "", "url": ""}, "installed": true, "description": "", "version": ""'


@pytest.mark.parametrize(
    "answer",
    [
        b'{"type":"info","data_length":100}\nabc',
        b"[]\n",
        b'{"type":"info","data":[]}\n',
        b'{"type":"info","data_length":"x"}\n',
        b'{"type":"info","data":{"asr":[%s,"models":[]}],"tts":[%s,"voices":[5]}]}}\n' % (NAMELESS, NAMELESS),
        b"[" * 50_000 + b"\n",
    ],
)
def test_a_server_that_speaks_something_else_is_told_as_away(answer: bytes) -> None:
    with answering(answer) as uri:
        for part in (WyomingRecognizer(uri, language="en", timeout_s=5.0), WyomingSynthesizer(uri, timeout_s=5.0)):
            with pytest.raises(UnavailableError, match="does not speak Wyoming"):
                part.load()


@pytest.mark.parametrize(
    ("uri", "why"),
    [("", "no address is set"), ("http://x:1", "of the form tcp"), ("tcp://127.0.0.1:1", "not reachable")],
)
def test_a_wyoming_server_that_is_not_there_is_told_as_away(uri: str, why: str) -> None:
    with pytest.raises(UnavailableError, match=why):
        WyomingRecognizer(uri, language="en", timeout_s=5.0).load()


class Transcriptions(BaseHTTPRequestHandler):
    """Tells back the fields it was sent, or what the address asks for."""

    def do_GET(self) -> None:
        self._answer(404, b"{}")

    def do_POST(self) -> None:
        body = self.rfile.read(int(self.headers["content-length"]))
        if self.path.startswith("/broken/"):
            return self._answer(500, b"{}")
        if self.path.startswith("/odd/"):
            return self._answer(200, b"[]")
        parts = BytesParser().parsebytes(b"content-type: " + self.headers["content-type"].encode() + b"\r\n\r\n" + body)
        fields = {
            one.get_param("name", header="content-disposition"): one.get_payload(decode=True) for one in parts.walk()
        }
        told = [f"{key}={fields[key].decode()}" for key in ("model", "language", "prompt") if key in fields]
        kind = fields["file"][:4].decode()
        text = " ".join([self.path, self.headers["authorization"], kind, *told])
        return self._answer(200, json.dumps({"text": text}).encode())

    def _answer(self, status: int, body: bytes) -> None:
        self.send_response(status)
        self.send_header("content-length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_: object) -> None: ...


@pytest.fixture(scope="module")
def transcriptions() -> Iterator[str]:
    with ThreadingHTTPServer(("127.0.0.1", 0), Transcriptions) as server:
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()
        yield f"http://127.0.0.1:{server.server_address[1]}"
        server.shutdown()
        thread.join(10.0)


def openai(url: str) -> OpenAiRecognizer:
    return OpenAiRecognizer(url, "small", language="en", timeout_s=5.0, api_key="secret")


def test_a_server_of_openais_format_is_sent_a_wav_and_what_to_expect(transcriptions: str) -> None:
    recognizer = openai(f"{transcriptions}/v1/")
    recognizer.load()
    plain, hot = (one.text for one in recognizer.readings(SECOND, ("", "cup, tea pot")))
    assert plain == "/v1/audio/transcriptions Bearer secret RIFF model=small language=en"
    assert hot == f"{plain} prompt=cup, tea pot"


@pytest.mark.parametrize(("path", "why"), [("/broken", "HTTP 500"), ("/odd", "no transcription")])
def test_a_server_of_openais_format_that_answers_something_else_is_told_as_away(
    transcriptions: str, path: str, why: str
) -> None:
    with pytest.raises(UnavailableError, match=why):
        next(openai(f"{transcriptions}{path}").readings(SECOND, ("",)))


@pytest.mark.parametrize(
    ("url", "why"), [("", "is not set"), ("http://127.0.0.1:1/v1", "not reachable"), ("nas/v1", "not reachable")]
)
def test_a_server_of_openais_format_that_is_not_there_is_told_as_away(url: str, why: str) -> None:
    with pytest.raises(UnavailableError, match=why):
        openai(url).load()


def test_piper_without_a_voice_is_told_as_away() -> None:
    with pytest.raises(UnavailableError, match="SPEECH_PIPER_VOICE"):
        PiperSynthesizer("").load()
