"""Stops the robot again and again and resets it by a key, until it is ended; then prints what the answers took."""

import argparse
import json
import os
import signal
import threading
import time
from collections import Counter

import httpx
import numpy as np


def stops(url: str, rate_hz: float, ended: threading.Event) -> dict[str, object]:
    """Each stop on a connection of its own, without a key, as a person's is."""
    took_ms, statuses = list[float](), Counter[str]()
    reset = {"Authorization": f"Bearer {os.environ['ATOM_KEY']}"}
    while not ended.wait(1.0 / rate_hz):
        began_s = time.monotonic()
        try:
            answer = httpx.post(f"{url}/emergency-stop", trust_env=False, timeout=30.0)
            statuses[str(answer.status_code)] += 1
            took_ms.append((time.monotonic() - began_s) * 1000.0)
            httpx.post(f"{url}/emergency-stop/reset", headers=reset, trust_env=False, timeout=30.0)
        except httpx.HTTPError as error:
            statuses[type(error).__name__] += 1
    p50, p99, most = np.percentile(took_ms or [0.0], [50, 99, 100])
    figures = {"p50_ms": round(float(p50), 1), "p99_ms": round(float(p99), 1), "max_ms": round(float(most), 1)}
    return {"stops": len(took_ms), "statuses": statuses, **figures}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--url", required=True)
    parser.add_argument("--rate-hz", type=float, default=2.0)
    arguments = parser.parse_args()
    ended = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: ended.set())
    print(json.dumps(stops(arguments.url, arguments.rate_hz, ended)), flush=True)  # noqa: T201 - read by bench.hostile


if __name__ == "__main__":
    main()
