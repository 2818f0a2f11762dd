"""Requests at a rate, whether or not the last ones have been answered: 1000 a second on one route."""

import asyncio
import json
import time
from collections import Counter
from dataclasses import dataclass, field

CONNECTIONS = 16
BOX = {"bbox_xyxy": [10, 10, 50, 50], "image_width_px": 250, "image_height_px": 250}
BOXES = {"boxes_xyxy": [[10, 10, 50, 50]], "image_width_px": 250, "image_height_px": 250}
POSE = {"x": 0.0, "y": 0.0, "yaw": 0.0}


def routes(epoch: int, gains: object) -> dict[str, object]:
    """Every route of the bridge with a body that it takes seriously; none for those that have no body.

    Moves are asked for with an epoch that is over: what is measured is the flood, not the driving. `gains` are the
    present ones. Left out is /camera/stream, whose answer has no end.
    """
    old = {"epoch": epoch - 1}
    return {
        "GET /health": None,
        "GET /ready": None,
        "GET /metrics": None,
        "GET /state": None,
        "GET /description": None,
        "GET /scan": None,
        "GET /obstacles": None,
        "GET /map": None,
        "GET /map.png": None,
        "GET /maps": None,
        "POST /map/same-home": {"id": "none"},
        "GET /camera/frame": None,
        "GET /emergency-stop": None,
        "GET /emergency-stop/history": None,
        "GET /motion/gains": None,
        "PUT /motion/gains": gains,
        "GET /navigation/goals/none": None,
        "DELETE /navigation/goals/none": None,
        "DELETE /motion": None,
        "POST /depth": BOX,
        "POST /localize": BOXES,
        "POST /velocity": {"twist": {"linear_x": 0.0}, "source": "flood", "duration_s": 0.1, **old},
        "POST /rotate": {"angle_rad": 1.0, **old},
        "POST /drive": {"distance_m": 0.5, **old},
        "POST /navigation/goals": {"candidates": [{"pose": POSE}], **old},
        "POST /navigation/path": {"goal": POSE},
        "POST /halt": None,
        "POST /celebrate": None,
        "POST /dock?session_id=none": None,
        "POST /undock?session_id=none": None,
        "GET /arm": None,
        "POST /arm/trajectory": {"joints": ["shoulder"], "points": [{"time_s": 1.0, "positions_rad": [0.0]}], **old},
        "POST /arm/gripper": {"opening": 0.5, **old},
        "POST /arm/home": old,
        "POST /arm/stop": None,
        "POST /recordings": {"name": "flood", "seconds_max": 1.0},
        "POST /recordings/none/stop": None,
        "GET /recordings": None,
        "GET /recordings/none": None,
        "GET /recordings/none/file": None,
        "DELETE /recordings/none": None,
        "GET /nowhere": None,
        "POST /emergency-stop": None,
        "POST /emergency-stop/reset": None,
    }


@dataclass
class Outcome:
    """What came of a flood: requests sent, answers by status, and how long the slowest took."""

    sent: int = 0
    statuses: Counter[str] = field(default_factory=Counter[str])
    slowest_s: float = 0.0


async def flood(port: int, route: str, body: object, *, rate_hz: float, seconds: float) -> Outcome:
    """Open loop over 16 connections: each writes on schedule and another task reads the answers."""
    outcome = Outcome()
    payload = b"" if body is None else json.dumps(body).encode()
    method, path = route.split()
    head = f"{method} {path} HTTP/1.1\r\nHost: bridge\r\nContent-Length: {len(payload)}\r\n"
    head += "Content-Type: application/json\r\n\r\n"
    request = head.encode() + payload
    workers = [
        _connection(port, request, outcome, rate_hz=rate_hz / CONNECTIONS, seconds=seconds) for _ in range(CONNECTIONS)
    ]
    await asyncio.gather(*workers)
    return outcome


async def _connection(port: int, request: bytes, outcome: Outcome, *, rate_hz: float, seconds: float) -> None:
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    sent_s: asyncio.Queue[float | None] = asyncio.Queue()
    reading = asyncio.create_task(_answers(reader, sent_s, outcome))
    loop = asyncio.get_running_loop()
    next_s = loop.time()
    end_s = next_s + seconds
    try:
        while next_s < end_s and not reading.done():
            writer.write(request)
            sent_s.put_nowait(time.monotonic())
            outcome.sent += 1
            next_s += 1.0 / rate_hz
            await asyncio.sleep(max(0.0, next_s - loop.time()))
        sent_s.put_nowait(None)
        async with asyncio.timeout(30.0):
            await reading
    except (OSError, TimeoutError) as error:
        outcome.statuses[type(error).__name__] += 1
    finally:
        reading.cancel()
        writer.close()


async def _answers(reader: asyncio.StreamReader, sent_s: "asyncio.Queue[float | None]", outcome: Outcome) -> None:
    while (began_s := await sent_s.get()) is not None:
        try:
            head = await reader.readuntil(b"\r\n\r\n")
        except asyncio.IncompleteReadError:
            outcome.statuses["closed"] += 1
            return
        lines = head.lower().split(b"\r\n")
        length = next((line for line in lines if line.startswith(b"content-length:")), b":0")
        await reader.readexactly(int(length.split(b":")[1]))
        outcome.statuses[lines[0].split()[1].decode()] += 1
        outcome.slowest_s = max(outcome.slowest_s, time.monotonic() - began_s)
