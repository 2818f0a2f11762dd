"""A stand-in of robot_bridge's camera over real HTTP: one new frame a request."""

import contextlib
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from support.inference_fakes import jpeg_of, picture


class Bridge(ThreadingHTTPServer):
    daemon_threads = True

    def __init__(self, port: int) -> None:
        super().__init__(("127.0.0.1", port), _Frames)
        self.served = 0
        self.jpeg = jpeg_of(picture(("red", (80, 60, 130, 200))))


class _Frames(BaseHTTPRequestHandler):
    server: Bridge

    def log_message(self, format: str, *args: Any) -> None:
        return

    def do_GET(self) -> None:
        self.server.served += 1
        self.send_response(200)
        self.send_header("Content-Type", "image/jpeg")
        self.send_header("Content-Length", str(len(self.server.jpeg)))
        self.send_header("X-Stamp-S", f"{self.server.served:.3f}")
        self.send_header("X-Pose", "1.0,2.0,0.5")
        self.end_headers()
        self.wfile.write(self.server.jpeg)


@contextlib.contextmanager
def running_bridge(port: int = 0) -> Iterator[str]:
    """Yields its base URL; on any free port unless one is named."""
    with Bridge(port) as running:
        thread = threading.Thread(target=running.serve_forever, kwargs={"poll_interval": 0.02})
        thread.start()
        yield f"http://127.0.0.1:{running.server_port}"
        running.shutdown()
        thread.join(5.0)
