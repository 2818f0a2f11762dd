"""What README.md and docs/ tell their reader to type, and where each command is run: in an empty environment, beside a
running mesh, or nowhere, with the reason."""

import re
from pathlib import Path

from markdown_it import MarkdownIt

from support.source import ROOT

MESH = "needs a running mesh, and more than tests/e2e/test_doc_commands.py gives it"
MISSION = "a mission of minutes: tests/e2e/test_finding.py plays one"
ROBOT = "needs a robot, or its ROS packages"
STAYS = "stays until it is ended"
LONG = "takes minutes, and installs: the gate (.ci/run) and tests/e2e play it"
NOT_RUN = {
    "ROS_DOMAIN_ID=0 ROBOT_BRIDGE_ROS__CMD_VEL_NAV__NAME=cmd_vel_to_bridge python -m robot_bridge": ROBOT,
    ".venv/bin/atom keys make anna --password": "asks for a password; tests/contract/cli play it",
    "ATOM_KEY_FILE=~/.config/atom.key atom find \"red bottle\"": MISSION,
    ".venv/bin/atom backup atom-backup.tar": MESH,
    ".venv/bin/atom backup before-the-update.tar": MESH,
    ".venv/bin/atom find \"blue cup\"": MISSION,
    ".venv/bin/atom restore --check atom-backup.tar": MESH,
    ".venv/bin/atom restore atom-backup.tar": MESH,
    "INFERENCE_MODEL_SET=coco python -m inference": "needs weights that are fetched by hand",
    ".venv/bin/python -m ear": "needs a microphone; tests/integration/ear let it hear a file",
    "arecord -q -f S16_LE -r 16000 -c 1 -t raw | EAR_SOUND=- .venv/bin/python -m ear": "needs a microphone",
    "git pull": "fetches",
    "make demo": LONG,
    "make demo COMMAND=\"find the blue cup\" SEED=4": LONG,
    "make demo ONCE=1": LONG,
    "make demo SPEECH=1": LONG,
    "ROBOT_BRIDGE_FOXGLOVE_PORT=8765 make demo": LONG,
    "ssh -N -L 8765:127.0.0.1:8765 robot": ROBOT,
    "make demo TOUR=0": LONG,
    "make doctor": ROBOT,
    "make setup": LONG,
    "make setup && . .venv/bin/activate": LONG,
    "make test": LONG,
    "make up; make down": LONG,
    "python -m memory; python -m coordinator; python -m ui": STAYS,
    "python -m sim --arm so101": STAYS,
    "ROBOT_BRIDGE_ARM=so101 python -m robot_bridge": STAYS,
    "redis-server --aclfile keys/redis.acl": STAYS,
    "redis-server --save \"\" &": STAYS,
}  # fmt: skip
BESIDE_A_MESH = {
    "README.md": r"curl -X POST .*",
    "compose.md": r"curl .*(/missions|/score\S+)'?",
    "first-hour.md": r"\.venv/bin/atom (status|memory|resume)|curl .*",
    "foxglove.md": r"(R=\$\()?curl .*",
    "security.md": r"curl .*",
}
"""Of a page, by its name, what tests/e2e/test_doc_commands.py runs."""
NOT_RUN_ALL = {
    r"((ATOM_SITE|UI_SPEECH_URL)=\S+ )*docker compose .*": "needs Docker",
    r"echo '.*' >> \.env": "is for docker compose",
    r"HOME_ASSISTANT_MQTT_HOST=.*": "needs a broker; tests/integration/home_assistant start one",
    r"ros2 .*": ROBOT,
    r"([ER]=\$\()?curl .*": MESH,
}
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def blocks(page: Path) -> list[str]:
    """What the page tells its reader to type."""
    found = MarkdownIt().parse(page.read_text(encoding="utf-8"))
    return [
        one.content for one in found if one.type == "fence" and one.info.strip() in {"sh", "bash", "console", "shell"}
    ]


def commands(page: Path) -> list[str]:
    """One after another, without the remarks behind them; a quote may go over several lines."""
    text = "\n".join(blocks(page)).replace("\\\n", " ")
    text = re.sub(r"(^|\s+)# .*$", "", text, flags=re.MULTILINE)
    return [one.strip() for one in re.findall(r"(?:'[^']*'|[^'\n])+", text) if one.strip()]


def beside_a_mesh(page: Path) -> list[str]:
    """The commands of a page that are run beside a running mesh, in their order."""
    return [one for one in commands(page) if re.fullmatch(BESIDE_A_MESH.get(page.name, "(?!)"), one, re.DOTALL)]


def is_run(command: str) -> bool:
    """In an empty environment."""
    elsewhere = (*NOT_RUN_ALL, *BESIDE_A_MESH.values())
    return command not in NOT_RUN and not any(re.fullmatch(one, command, re.DOTALL) for one in elsewhere)
