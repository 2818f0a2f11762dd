"""Hostile requests to every service of the running mesh, while the robot is stopped and reset twice a second.

The real mesh: every service, speech too, Redis with its rules, the simulated robot, keys. Requests are drawn from each
service's OpenAPI document, sensible and senseless, with every role's key, a wrong one and none; between them come
malformed bodies, slow and silent clients, WebSockets full of garbage (bench/hostility/attacks.py), messages on Redis.
Judged: no 500, no traceback, no process ended, memory and handles as before, stops answered, the robot moves and stops.
"""

import argparse
import asyncio
import json
import os
import random
import signal
import subprocess
import sys
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import httpx
from redis.exceptions import RedisError

from bench.hostility import bus
from bench.hostility.attacks import ATTACKS, Target, attack
from bench.hostility.drawing import Document, Request
from bench.hostility.holding import Holding, complaints, grown, holdings
from bench.hostility.mesh import GuardedMesh, guarded
from bench.hostility.wire import ANSWER_S_MAX, answer, connection, encoded
from bench.processes import ROOT
from bench.results import save

STOP_MS_MAX: Final = 2000.0
"""The mesh, its clients and the simulation share the machine: what `bench.stop` measures is the aim."""
HANDLES_MORE_MAX: Final = 10
MIB_MORE_MAX: Final = 64.0
QUIET_S: Final = 20.0
WARM_PART: Final = 0.1
SOCKETS: Final = {
    "coordinator": ("/events",),
    "robot_bridge": ("/velocity", "/session"),
    "speech": ("/listen",),
    "ui": ("/live/camera", "/live/scene", "/teleop", "/_nicegui_ws/socket.io/?EIO=4&transport=websocket"),
}
POSTS: Final = {
    "coordinator": "/missions",
    "inference": "/detect",
    "memory": "/recall",
    "robot_bridge": "/velocity",
    "speech": "/transcribe",
    "ui": "/login",
}


@dataclass
class Tally:
    wanted: int
    minutes: float
    sent: int = 0
    statuses: dict[str, Counter[str]] = field(default_factory=dict[str, Counter[str]])
    failed: Counter[str] = field(default_factory=Counter[str])
    began_s: float = field(default_factory=time.monotonic)

    def take(self, service: str, what: str, status: str, *, meant: bool = False) -> None:
        """`meant` is an answer that the request asked for."""
        self.sent += 1
        self.statuses.setdefault(service, Counter())[status] += 1
        if status in {"500", "502", "504", "silent"} and not meant:
            self.failed[f"{status} {service} {what}"] += 1

    def wants(self, until: int) -> bool:
        """Whether there is anything left to send, and time for it."""
        return self.sent < until and time.monotonic() < self.began_s + self.minutes * 60.0

    def told(self) -> str:
        rate_hz = self.sent / (time.monotonic() - self.began_s)
        left_min = (self.wanted - self.sent) / max(rate_hz, 0.1) / 60.0
        return f"{self.sent}/{self.wanted} sent, {rate_hz:.0f} a second, {left_min:.1f} min left, {dict(self.failed)}\n"


def too_late_a_frame(service: str, request: Request, status: str, *, now_s: float) -> bool:
    """Whether a 504 is what was asked for: `POST /validate` of a frame later than `now_s`, when it was sent."""
    if (service, request.method, request.path, status) != ("inference", "POST", "/validate", "504"):
        return False
    try:
        asked = json.loads(request.body)
    except ValueError:
        return False
    after_s = asked.get("after_stamp_s") if isinstance(asked, dict) else None
    return isinstance(after_s, int | float) and after_s > now_s


class Sender:
    """Workers that send whatever comes to their mind until so many have been sent."""

    def __init__(self, mesh: GuardedMesh, tally: Tally, chance: random.Random) -> None:
        self._mesh = mesh
        self._tally = tally
        self._chance = chance
        self._documents = {
            name: Document(httpx.get(mesh.url(name, "/openapi.json"), trust_env=False).json(), chance)
            for name in mesh.stack.calls
        }
        self._weights = [weight for weight, _ in ATTACKS.values()]

    async def send(self, until: int, workers: int) -> None:
        services = tuple(self._documents)
        work = [self._work(services[number % len(services)], until) for number in range(workers)]
        await asyncio.gather(*work, self._report(until))

    async def _report(self, until: int) -> None:
        while self._tally.wants(until):
            await asyncio.sleep(5.0)
            sys.stdout.write(self._tally.told())
            sys.stdout.flush()

    async def _work(self, service: str, until: int) -> None:
        while self._tally.wants(until):
            drawn = self._chance.random()
            if drawn < 0.02:
                await self._on_the_bus()
            elif drawn < 0.17:
                await self._attack(service)
            else:
                await self._drawn(service, until)

    def _header(self) -> dict[str, str]:
        role = self._chance.choice((*self._mesh.keys, "admin", "admin", ""))
        return {"Authorization": f"Bearer {self._mesh.keys[role]}"} if role else {}

    async def _on_the_bus(self) -> None:
        try:
            self._tally.take("redis", "", await bus.publish(self._mesh.stack, self._chance))
        except (RedisError, OSError) as error:
            self._tally.take("redis", "", type(error).__name__)

    async def _attack(self, service: str) -> None:
        (name,) = self._chance.choices(list(ATTACKS), self._weights)
        header = "".join(f"{key}: {value}\r\n" for key, value in self._header().items())
        port = getattr(self._mesh.ports, service)
        target = Target(port, POSTS[service], SOCKETS.get(service, ()), header)
        self._tally.take(service, name, await attack(name, target, self._chance))

    async def _drawn(self, service: str, until: int) -> None:
        """Some on one connection."""
        port = getattr(self._mesh.ports, service)
        what, again = "", True
        try:
            async with connection(port) as (reader, writer):
                while again and self._tally.wants(until):
                    request = self._documents[service].request()
                    what = f"{request.method} {request.path[:60]}"
                    sent_s = time.time()
                    writer.write(encoded(request, f"127.0.0.1:{port}", self._header()))
                    async with asyncio.timeout(ANSWER_S_MAX):
                        status, again = await answer(reader, request.method)
                    meant = too_late_a_frame(service, request, status, now_s=sent_s)
                    self._tally.take(service, what, status, meant=meant)
                    again = again and self._chance.random() < 0.9
        except TimeoutError:  # before OSError, which it is one of
            self._tally.take(service, what, "silent")
        except (OSError, asyncio.IncompleteReadError):
            self._tally.take(service, what, "closed")


def flat(before: dict[str, Holding], after: dict[str, Holding]) -> list[str]:
    """A sentence for each process that has ended, or holds more than it may."""
    said = list[str]()
    for name, was in before.items():
        now = after.get(name)
        if now is None or now.pid != was.pid:
            said.append(f"{name} is another process now")
        elif now.handles > was.handles + HANDLES_MORE_MAX:
            said.append(f"{name} holds {now.handles} handles after {was.handles}")
        elif now.rss_mib > was.rss_mib + MIB_MORE_MAX:
            said.append(f"{name} holds {now.rss_mib} MiB after {was.rss_mib}")
    return said


def campaign(mesh: GuardedMesh, tally: Tally, workers: int, seed: int) -> dict[str, Any]:
    """What came of it; `faults` is empty when everything went well."""
    gains = mesh.get("robot_bridge", "/motion/gains")
    command = [sys.executable, "-m", "bench.hostility.stops", "--url", mesh.ports.url("robot_bridge")]
    environment = os.environ | {"ATOM_KEY": mesh.keys["operator"]}
    stopping = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment, cwd=ROOT)
    requests = tally.wanted
    try:
        sender = Sender(mesh, tally, random.Random(seed))
        started = holdings(mesh.stack)
        asyncio.run(sender.send(round(requests * WARM_PART), workers))
        time.sleep(QUIET_S)
        before = holdings(mesh.stack)
        asyncio.run(sender.send(requests, workers))
        sending_s = time.monotonic() - tally.began_s
    finally:
        stopping.terminate()
        output, _ = stopping.communicate(timeout=60.0)
    stops = json.loads(output)
    time.sleep(QUIET_S)
    after = holdings(mesh.stack)
    faults = flat(before, after) + [f"{what}: {times} times" for what, times in tally.failed.items()]
    faults += [f"{name} started {now.pid} before" for name, now in started.items() if now.pid != before[name].pid]
    faults += [f"{name}: {lines}" for name, lines in complaints(mesh.stack).items()]
    if stops["stops"] == 0 or stops["max_ms"] > STOP_MS_MAX:
        faults.append(f"{stops['stops']} stops were answered, the slowest after {stops['max_ms']:.0f} ms")
    faults += [f"{count} stops answered {status}" for status, count in stops["statuses"].items() if status != "200"]
    then: dict[str, Any] = {}
    try:
        mesh.http.put(mesh.url("robot_bridge", "/motion/gains"), json=gains).raise_for_status()
        mesh.until(mesh.ready, timeout_s=60.0, what="every service ready")
        then = mesh.moves_and_stops()
    except (AssertionError, httpx.HTTPError) as error:
        faults.append(str(error))
    return {
        "requests": tally.sent,
        "seconds": round(sending_s, 1),
        "statuses": {name: dict(sorted(counts.items())) for name, counts in tally.statuses.items()},
        "stops": stops,
        "holdings": grown(before, after),
        "bounds": {"handles_more": HANDLES_MORE_MAX, "mib_more": MIB_MORE_MAX},
        "afterwards": then,
        "faults": faults,
        "load_average": os.getloadavg(),
    }


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--requests", type=int, default=100_000)
    parser.add_argument("--workers", type=int, default=40, help="at once, over all services")
    parser.add_argument("--minutes", type=float, default=240.0, help="of sending at most; what was sent is judged")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--port-base", type=int, default=9300)
    parser.add_argument("--out", type=Path, default=Path("out/bench/hostile.json"))
    arguments = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    with guarded(arguments.port_base, seed=3, speech=True) as mesh:
        result = campaign(mesh, Tally(arguments.requests, arguments.minutes), arguments.workers, arguments.seed)
        logs = arguments.out.parent / "hostile_logs"
        logs.mkdir(parents=True, exist_ok=True)
        for file in mesh.stack.logs.glob("*.log"):
            (logs / file.name).write_bytes(file.read_bytes())
    save(arguments.out, result)
    sys.stdout.write(json.dumps(result, indent=1) + f"\n{arguments.out}\n")
    return 1 if result["faults"] else 0


if __name__ == "__main__":
    sys.exit(main())
