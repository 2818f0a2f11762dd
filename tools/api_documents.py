"""Writes what the services say of themselves into docs/api: `make api`; `--check` compares and writes nothing.

A change that breaks somebody is written only with `--breaking`.
"""

import argparse
import json
import sys
from importlib import import_module
from pathlib import Path
from typing import Any, Final

import api_messages
from api_changes import changes
from api_consumers import callers

PLACE: Final = Path(__file__).parents[1] / "docs/api"
NOBODY: Final = "no service of ours, perhaps somebody's script"
SERVICES: Final = ("coordinator", "inference", "memory", "robot_bridge", "speech", "ui")


def openapi(service: str) -> dict[str, Any]:
    """The document the running service gives at /openapi.json."""
    settings = import_module(f"{service}.settings").Settings()
    return import_module(f"{service}.app").create_app(settings).openapi()


def text_of(document: dict[str, Any]) -> str:
    return json.dumps(document, indent=2, sort_keys=True, ensure_ascii=False) + "\n"


def committed(service: str) -> dict[str, Any]:
    """The committed document; one without routes where there is none yet."""
    path = PLACE / f"{service}.openapi.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {"paths": {}}


def differences(service: str, document: dict[str, Any]) -> tuple[list[str], list[str]]:
    """(what the document breaks, what else is another) against the committed one, a sentence each."""
    old = committed(service)
    found, who = changes(old, document), callers(old, service)
    breaking = [
        f"{service}: {one.operation} {one.text}. It breaks {', '.join(who.get(one.operation, [NOBODY]))}."
        for one in found
        if not one.added
    ]
    besides = [f"{service}: {one.operation} {one.text}." for one in found if one.added]
    if not found and document != old:
        besides.append(f"{service}: its document is another, and breaks nobody.")
    return breaking, besides


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; fail where a document is another")
    parser.add_argument("--breaking", action="store_true", help="write what breaks somebody, too")
    asked = parser.parse_args()
    documents, bus = {service: openapi(service) for service in SERVICES}, api_messages.asyncapi()
    told = [differences(service, document) for service, document in documents.items()]
    told.append(api_messages.differences(bus))
    breaking, besides = [text for one, _ in told for text in one], [text for _, one in told for text in one]
    sys.stderr.writelines(f"BREAKS  {text}\n" for text in breaking)
    sys.stderr.writelines(f"changes {text}\n" for text in besides)
    if asked.check or (breaking and not asked.breaking):
        hint = "make api BREAKING=1 writes it all the same" if breaking else "make api writes it"
        sys.stderr.write(f"{hint}\n" if breaking or besides else "")
        return 1 if breaking or besides else 0
    for service, document in documents.items():
        (PLACE / f"{service}.openapi.json").write_text(text_of(document), encoding="utf-8")
    api_messages.DOCUMENT.write_text(api_messages.text_of(bus), encoding="utf-8")
    api_messages.pin()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
