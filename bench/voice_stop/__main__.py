"""How soon, how surely and how wrongly is a spoken stop heard? out/bench/voice-stop.md"""

import argparse
import asyncio
import contextlib
import json
import os
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

from bench.processes import Processes
from bench.stopping.rig import rigged
from bench.voice_stop import false_stops, stops

OUT = Path("out/bench/voice-stop")
SPIN = "while True: pass"


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--rounds", type=int, default=3, help="of every saying, voice and noise; 0 = none")
    options.add_argument("--busy", type=int, default=2, help="processes that do nothing but take a core each")
    options.add_argument(
        "--seconds", type=float, default=24 * 3600.0, help="listens to other speech for so long; 0 = none"
    )
    options.add_argument("--port", type=int, default=9400, help="of the bridge; Redis and speech take the next two")
    options.add_argument("--domain", type=int, default=94, help="ROS_DOMAIN_ID")
    asked = options.parse_args()
    OUT.mkdir(parents=True, exist_ok=True)
    if asked.rounds:
        _measure(asked.rounds, asked.busy, asked.port, asked.domain)
    if asked.seconds > 0.0:
        asyncio.run(false_stops.play(OUT / "other.jsonl", OUT / "sounds", asked.seconds))
    told = ""
    for file in sorted(OUT.glob("stops-busy*.json")):
        kept = json.loads(file.read_text(encoding="utf-8"))
        told += f"{kept['context']}\n\n" + stops.table([stops.Spoken(**one) for one in kept["spoken"]]) + "\n"
    told += false_stops.table(false_stops.kept(OUT / "other.jsonl"))
    (OUT / "voice-stop.md").write_text(told, encoding="utf-8")
    sys.stdout.write(told)


def _measure(rounds: int, busy: int, port: int, domain: int) -> None:
    with (
        tempfile.TemporaryDirectory() as folder,
        stops.speech_service(port + 2),
        rigged(Path(folder), port, domain, 0.0, secured=False) as rig,
        _busy(busy),
    ):
        told = asyncio.run(stops.measure(rig, port + 2, OUT / "sounds", rounds))
        load = [round(one, 1) for one in os.getloadavg()]
    context = {"busy processes": busy, "cores": os.cpu_count(), "load average": load}
    kept = {"context": context, "spoken": [asdict(one) for one in told]}
    (OUT / f"stops-busy{busy}.json").write_text(json.dumps(kept, indent=1), encoding="utf-8")


@contextlib.contextmanager
def _busy(count: int) -> Iterator[None]:
    with Processes({}) as processes:
        for _ in range(count):
            processes.python("-c", SPIN)
        yield


if __name__ == "__main__":
    main()
