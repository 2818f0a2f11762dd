"""Writes every declared action into docs/actions.md: `.venv/bin/python tools/actions_page.py`."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final, cast

from contracts.actions import SPECS, ActionName, ActionSpec, tool_schema

PAGE: Final = Path(__file__).parents[1] / "docs/actions.md"
HEAD: Final = """# Actions

Written by `.venv/bin/python tools/actions_page.py` from `contracts.actions`; a test compares. Everything that a person,
a program or a language model can ask of the robot is declared there once, as a typed model with bounds. No action is a
velocity, and whoever moves goes through robot_bridge's arbiter and safety filter as ever.

- **HTTP**: `GET /actions` of the coordinator is this page as data, each action with the JSON schema of its arguments,
  as models that call tools take it. `POST /actions` does one: `{"action": "drive", "distance_m": 0.5}`. What moves the
  robot is a mission (201): queued, reported, recorded, and paused, cancelled and stopped as any other. Questions and
  orders are answered (200). Refused: 403 (role), 409 (stopped, or low on power), 422 (not declared, out of bounds,
  names nothing known; `code` says which), 429 (the queue is full). `POST /actions/stop` stops without a key and
  without a body.
- **Terminal**: `atom do ACTION`, as in `atom do drive --distance-m 0.5`; `atom do ACTION --help` tells the arguments.
- **MCP**: the same as tools, `stop` first ([mcp.md](mcp.md)).

In words, "go to the bedroom" is `go_to` with a room: where two rooms may be meant the answer is the question back
(422 `which_room`), and where memory knows no such room it says which it knows (422 `no_rooms`).

| action | what it does | who may | ends as | within |
|---|---|---|---|---|
"""


def page() -> str:
    rows = "".join(_row(name, spec) for name, spec in SPECS.items())
    return HEAD + rows + "".join(_section(name) for name in SPECS if _arguments(name))


def _row(name: ActionName, spec: ActionSpec) -> str:
    who = spec.role.value if spec.role is not None else "**anybody**"
    ends = ", ".join(end.value for end in spec.ends) or "an answer"
    needs = f" Needs: {', '.join(need.value for need in spec.needs)}." if spec.needs else ""
    return f"| `{name.value}` | {spec.sentence}{needs} | {who} | {ends} | {spec.limit_s:g} s |\n"


def _section(name: ActionName) -> str:
    rows = "".join(
        f"| `{key}` | {one['type']} | {'yes' if needed else ''} | {_bounds(one)} | {one['description']} |\n"
        for key, one, needed in _arguments(name)
    )
    return f"\n## {name.value}\n\n| argument | type | needed | bounds | |\n|---|---|---|---|---|\n{rows}"


def _arguments(name: ActionName) -> list[tuple[str, dict[str, Any], bool]]:
    schema = cast(dict[str, Any], tool_schema(name).parameters)
    return [(key, argument, key in schema["required"]) for key, argument in schema["properties"].items()]


def _bounds(argument: dict[str, Any]) -> str:
    return ", ".join(_bound(argument))


def _bound(argument: dict[str, Any]) -> Iterator[str]:
    for key, word in (("minimum", "from"), ("maximum", "to")):
        if key in argument:
            yield f"{word} {argument[key]:g}"
    for key, word in (("maxLength", "letters"), ("maxItems", "items")):
        if key in argument:
            yield f"at most {argument[key]} {word}"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
