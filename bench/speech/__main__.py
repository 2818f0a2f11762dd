"""How often is a spoken command understood as it was meant? Goes on where it was ended, then reports."""

import argparse
import asyncio
import sys
from pathlib import Path

from bench.speech.playing import clips, play
from bench.speech.report import table

OUT = Path(__file__).parents[2] / "out" / "bench" / "speech"


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--seconds", type=float, default=24 * 3600.0, help="listens for so long; 0 = reports alone")
    asked = options.parse_args()
    readings = OUT / "readings.jsonl"
    if asked.seconds > 0.0:
        play(readings, OUT / "sounds", asked.seconds)
    told = asyncio.run(table(clips(readings)))
    (OUT / "table.md").write_text(told, encoding="utf-8")
    sys.stdout.write(told)


if __name__ == "__main__":
    main()
