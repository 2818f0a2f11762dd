"""Writes who may what of every route, socket and mount: `.venv/bin/python tools/access_page.py`, docs/api/access.md."""

from importlib import import_module
from pathlib import Path
from typing import Final

from fastapi import FastAPI

from contracts.access import CALLERS, Role
from contracts.topics import ALL_TOPICS
from mesh.access.policies import RoutePolicy, route_policies

PAGE: Final = Path(__file__).parents[1] / "docs/api/access.md"
HEAD: Final = """# Who may what

Written by `.venv/bin/python tools/access_page.py` from what each route declares; a test compares it, and asks each
route with each role. What no line names asks for a viewer and is then 404. See [security](../security.md).

"""


def app_of(service: str) -> FastAPI:
    """With settings as they are by default; nothing is opened."""
    settings = import_module(f"{service}.settings").Settings()
    app: FastAPI = import_module(f"{service}.app").create_app(settings)
    return app


def policies(service: str) -> tuple[RoutePolicy, ...]:
    return route_policies(app_of(service).routes)


def page() -> str:
    roles = "".join(f"- `{role}`: {_meaning(role)}\n" for role in Role)
    return f"{HEAD}{roles}{''.join(map(_section, CALLERS))}{_bus()}"


def _meaning(role: Role) -> str:
    return {
        Role.VIEWER: "looks; moves and changes nothing",
        Role.OPERATOR: "also sends the robot, resets a stop, forgets what was remembered wrongly",
        Role.SERVICE: "also what only services ask of each other",
        Role.ADMIN: "also tunes the drives, deletes recordings, replaces the memory on the page",
    }[role]


def _section(service: str) -> str:
    rows = "".join(f"| {one.method} | `{one.path}` | {one.role or '**open**'} |\n" for one in policies(service))
    return f"\n## {service}\n\n| method | path | lowest role |\n|---|---|---|\n{rows}"


def _bus() -> str:
    rows = "".join(f"| `{one.name}` | {one.publisher} | {', '.join(one.listeners) or '-'} |\n" for one in ALL_TOPICS)
    return f"\n## Redis\n\n| topic | publishes | listens |\n|---|---|---|\n{rows}"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
