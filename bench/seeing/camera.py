"""A stand-in for robot_bridge's camera, as a process: GET /camera/frame with its long-poll, at a steady rate."""

import argparse
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit


class StandInCamera(ThreadingHTTPServer):
    """Shows one picture after the other; the stamp is the moment it appears."""

    daemon_threads = True

    def __init__(self, port: int, pictures: list[bytes], rate_hz: float) -> None:
        super().__init__(("127.0.0.1", port), _Frames)
        self._pictures, self._rate_hz = pictures, rate_hz
        self._changed = threading.Condition()
        self._shown = 0
        self._stamp_s = 0.0

    def run_shutter(self) -> None:
        next_s = time.monotonic()
        while True:
            next_s = max(next_s + 1.0 / self._rate_hz, time.monotonic())
            time.sleep(max(0.0, next_s - time.monotonic()))
            with self._changed:
                self._stamp_s = time.time()
                self._shown += 1
                self._changed.notify_all()

    def newest(self, after_s: float, wait_s: float) -> tuple[float, bytes] | None:
        with self._changed:
            if not self._changed.wait_for(lambda: self._stamp_s > after_s + 1e-6, wait_s):
                return None
            return self._stamp_s, self._pictures[self._shown % len(self._pictures)]


class _Frames(BaseHTTPRequestHandler):
    server: StandInCamera
    protocol_version = "HTTP/1.1"

    def setup(self) -> None:
        super().setup()
        self.wfile = self.connection.makefile("wb", buffering=65536)  # head and picture leave together

    def log_message(self, format: str, *args: Any) -> None:
        return

    def do_GET(self) -> None:
        asked = parse_qs(urlsplit(self.path).query)
        found = self.server.newest(float(asked.get("after", ["0"])[0]), float(asked.get("wait_s", ["0"])[0]))
        self.send_response(204 if found is None else 200)
        if found is not None:
            self.send_header("Content-Type", "image/jpeg")
            self.send_header("X-Stamp-S", f"{found[0]:.6f}")
            self.send_header("X-Pose", "1.0,2.0,0.5")
        self.send_header("Content-Length", str(len(found[1]) if found is not None else 0))
        self.end_headers()
        if found is not None:
            self.wfile.write(found[1])
        self.wfile.flush()


def main() -> None:
    parser = argparse.ArgumentParser(prog="bench.seeing.camera", description=__doc__)
    parser.add_argument("--port", type=int, required=True)
    parser.add_argument("--rate-hz", type=float, default=30.0)
    parser.add_argument("pictures", type=Path, nargs="+", help="JPEG files")
    arguments = parser.parse_args()
    camera = StandInCamera(arguments.port, [path.read_bytes() for path in arguments.pictures], arguments.rate_hz)
    threading.Thread(target=camera.run_shutter, daemon=True).start()
    camera.serve_forever()


if __name__ == "__main__":
    main()
