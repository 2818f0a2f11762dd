"""Writes the page of the mission states: `python -m coordinator.write_states docs/mission-transitions.md`."""

import argparse
from pathlib import Path

from coordinator.core import reactions, transitions
from coordinator.manipulation.transitions import page as fetch_page


def page() -> str:
    return transitions.page() + reactions.section()


def main() -> None:
    parser = argparse.ArgumentParser(description="Writes the table of mission states and its diagram.")
    parser.add_argument("path", type=Path, help="the page, e.g. docs/mission-transitions.md")
    parser.add_argument("--of", choices=("mission", "fetch"), default="mission", help="whose states")
    asked = parser.parse_args()
    asked.path.write_text(page() if asked.of == "mission" else fetch_page(), encoding="utf-8")


if __name__ == "__main__":
    main()
