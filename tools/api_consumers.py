"""Who asks what of whom, read from the committed examples in tests/data/consumers, one file a pair of services."""

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import jsonschema_rs
from api_changes import Schema, operations

PLACE: Final = Path(__file__).parents[1] / "tests/data/consumers"


@dataclass(frozen=True)
class Example:
    """One request as a consumer's own client sent it, and what it was answered."""

    consumer: str
    provider: str
    call: str
    request: dict[str, Any]
    answer: dict[str, Any]


def examples(consumer: str, provider: str) -> list[Example]:
    """In the order in which they were sent; the ids in later ones come from the answers to earlier ones."""
    text = (PLACE / f"{consumer}.{provider}.json").read_text(encoding="utf-8")
    return [Example(consumer, provider, **one) for one in json.loads(text)]


def pairs() -> list[tuple[str, str]]:
    """(consumer, provider) of each file."""
    return [(path.name.split(".")[0], path.name.split(".")[1]) for path in sorted(PLACE.glob("*.json"))]


def operation_of(document: Schema, example: Example) -> str:
    """'GET /missions/{mission_id}' of the provider's document, the route with the fewest variables first; or ''."""
    method, path = example.request["method"], example.request["path"]
    routes = sorted((name.split(" ") for name, _ in operations(document)), key=lambda route: route[1].count("{"))
    fits = (f"{verb} {route}" for verb, route in routes if verb == method and re.fullmatch(_pattern(route), path))
    return next(fits, "")


def callers(document: Schema, provider: str) -> dict[str, list[str]]:
    """Of each operation of a provider, who calls it."""
    found: dict[str, list[str]] = {}
    for example in _of(provider):
        who = found.setdefault(operation_of(document, example), [])
        if example.consumer not in who:
            who.append(example.consumer)
    return found


def _of(provider: str) -> Iterator[Example]:
    for consumer, asked in pairs():
        if asked == provider:
            yield from examples(consumer, provider)


def _pattern(route: str) -> str:
    return re.sub(r"\\\{\w+\\\}", "[^/]+", re.escape(route.replace(":path", "")))


def misfits(document: Schema, example: Example) -> list[str]:
    """Where an example is not as the provider's document says."""
    name = operation_of(document, example)
    said = dict(operations(document)).get(name)
    if said is None:
        return [f"{example.request['method']} {example.request['path']} is no route"]
    known = {one["name"] for one in said["parameters"] if one["in"] == "query"}
    found = [f"{name} has no query parameter {key}" for key in example.request["query"] if key not in known]
    status = str(example.answer["status"])
    answers = said["responses"].get(status) or said["responses"].get(f"{status[0]}XX")
    if answers is None:
        return [*found, f"{name} never answers {status}"]
    for body, kinds in ((example.request["body"], said.get("requestBody", {})), (example.answer["body"], answers)):
        schema = kinds.get("content", {}).get(body.get("type"), {}).get("schema")
        if schema is not None and "json" in body:
            validator = jsonschema_rs.validator_for({**schema, "components": document["components"]})
            found += [f"{name}: {error}" for error in validator.iter_errors(body["json"])]
        elif body and body["type"] not in kinds.get("content", {}):
            found.append(f"{name} has no body of {body['type']}")
    return found
