"""How often is a spoken command understood as it was meant? python -m bench.speech [play|report]"""

import argparse
from pathlib import Path

from bench.speech.playing import play

ROOT = Path(__file__).parents[2]
OUT = ROOT / "out" / "bench" / "speech"


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--seconds", type=float, default=24 * 3600.0, help="reads for so long, then reports")
    asked = options.parse_args()
    play(OUT / "readings.jsonl", OUT / "sounds", asked.seconds)


if __name__ == "__main__":
    main()
