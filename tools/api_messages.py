"""What is said on the bus: the AsyncAPI document of `contracts.topics`, and one whole message of each topic."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import yaml
from api_changes import Gap, Kind, accepts
from pydantic.json_schema import models_json_schema

from contracts.topics import ALL_TOPICS, Topic

DOCUMENT: Final = Path(__file__).parents[1] / "docs/api/asyncapi.yaml"
MESSAGES: Final = Path(__file__).parents[1] / "tests/data/messages"
TRACEPARENT: Final = {
    "type": "string",
    "description": "W3C trace context in which it was said; the first field of the message where it is there at all",
}


def asyncapi() -> dict[str, Any]:
    """AsyncAPI 3.0; the operations name the services, since one document describes all of them."""
    _, said = models_json_schema(
        [(topic.message, "serialization") for topic in ALL_TOPICS], ref_template="#/components/schemas/{model}"
    )
    schemas: dict[str, Any] = said["$defs"]
    return {
        "asyncapi": "3.0.0",
        "info": {
            "title": "atom: what services tell on the bus",
            "version": "0.1.0",
            "description": "Facts over Redis pub/sub: they may be lost, the newest wins, and nobody waits for them.",
        },
        "defaultContentType": "application/json",
        "servers": {"redis": {"host": "redis:6379", "protocol": "redis"}},
        "channels": {topic.name: _channel(topic) for topic in ALL_TOPICS},
        "operations": {name: one for topic in ALL_TOPICS for name, one in _operations(topic).items()},
        "components": {
            "messages": {topic.message.__name__: _message(schemas[topic.message.__name__]) for topic in ALL_TOPICS},
            "schemas": schemas,
        },
    }


def _channel(topic: Topic[Any]) -> dict[str, Any]:
    name = topic.message.__name__
    kept = {"x-kept-at": topic.kept_key} if topic.kept else {}
    return {"address": topic.name, "messages": {name: {"$ref": f"#/components/messages/{name}"}}, **kept}


def _operations(topic: Topic[Any]) -> dict[str, Any]:
    def operation(service: str, action: str) -> dict[str, Any]:
        return {"action": action, "channel": {"$ref": f"#/channels/{topic.name}"}, "tags": [{"name": service}]}

    heard = {f"{service} hears {topic.name}": operation(service, "receive") for service in topic.listeners}
    return {f"{topic.publisher} tells {topic.name}": operation(topic.publisher, "send"), **heard}


def _message(schema: Mapping[str, Any]) -> dict[str, Any]:
    payload = {**schema, "properties": {**schema["properties"], "traceparent": TRACEPARENT}}
    return {"contentType": "application/json", "payload": payload}


def text_of(document: Mapping[str, Any]) -> str:
    return yaml.safe_dump(document, sort_keys=False, allow_unicode=True, width=120)


def committed() -> dict[str, Any]:
    """The committed document; one without channels where there is none yet."""
    return yaml.safe_load(DOCUMENT.read_text(encoding="utf-8")) if DOCUMENT.exists() else {"channels": {}}


def differences(new: Mapping[str, Any]) -> tuple[list[str], list[str]]:
    """(what the document breaks, what else is another) against the committed one, a sentence each."""
    old, breaking, besides = committed(), list[str](), list[str]()
    for name in old["channels"]:
        if name not in new["channels"]:
            breaking.append(f"{name} is gone. It breaks {_who(old, name, 'receive')}.")
            continue
        was, now = _payload(old, name), _payload(new, name)
        breaking += [
            f"{name}: a message said before is not understood: {_told(gap)}. It breaks {_who(new, name, 'receive')}."
            for gap in accepts(now, was, new, old)
            if gap.kind is not Kind.GONE
        ]
        for gap in accepts(was, now, old, new):
            who = f"{_who(old, name, 'receive')} of the release before"
            listed = besides if gap.kind is Kind.UNKNOWN else breaking
            listed.append(f"{name}: a message said now is not understood before: {_told(gap)}. It breaks {who}.")
    if not breaking and not besides and old != new:
        besides.append("the bus: its document is another, and breaks nobody.")
    return breaking, besides


def _payload(document: Mapping[str, Any], channel: str) -> dict[str, Any]:
    (name,) = document["channels"][channel]["messages"]
    return document["components"]["messages"][name]["payload"]


def _told(gap: Gap) -> str:
    match gap.kind:
        case Kind.MISSING:
            return f"`{gap.path}` may be missing"
        case Kind.GONE:
            return f"`{gap.path}` never comes"
        case Kind.UNKNOWN:
            return f"`{gap.path}` is not known"
        case Kind.OTHER:
            return f"`{gap.path}` {gap.text}"


def _who(document: Mapping[str, Any], channel: str, action: str) -> str:
    names = [
        one["tags"][0]["name"]
        for one in document["operations"].values()
        if one["action"] == action and one["channel"]["$ref"] == f"#/channels/{channel}"
    ]
    return ", ".join(names) or "nobody"


def whole(topic: Topic[Any]) -> dict[str, Any]:
    """A message in which every field of the topic has a value: its first example where it names one."""
    schema = topic.message.model_json_schema(mode="validation")
    built = _value(schema, schema, topic.message.__name__)
    return json.loads(topic.encode(topic.message.model_validate(built)))


def _value(schema: Mapping[str, Any], root: Mapping[str, Any], name: str) -> Any:  # noqa: PLR0911 - one a kind
    if "$ref" in schema:
        return _value(root["$defs"][schema["$ref"].rsplit("/", 1)[-1]], root, name)
    if "anyOf" in schema:
        return _value(next(one for one in schema["anyOf"] if one.get("type") != "null"), root, name)
    if said := schema.get("examples") or schema.get("enum") or ([schema["const"]] if "const" in schema else []):
        return said[0]
    match schema.get("type"):
        case "object" if "properties" in schema:
            return {key: _value(one, root, key) for key, one in schema["properties"].items()}
        case "object":
            return {"name": _value(schema.get("additionalProperties") or {}, root, name)}
        case "array":
            items = schema.get("prefixItems") or [schema.get("items", {})] * max(1, schema.get("minItems", 0))
            return [_value(one, root, name) for one in items]
        case "number" | "integer":
            return max(1, schema.get("minimum", 0)) if schema.get("maximum", 1) >= 1 else schema["maximum"]
        case "boolean":
            return True
        case _:
            return name[: schema.get("maxLength", 64)]


def pinned(topic: Topic[Any]) -> list[Path]:
    """The topic's committed messages, oldest first; none of them is ever rewritten."""
    return sorted(MESSAGES.glob(f"{topic.name}.*.json"), key=lambda path: int(path.name.split(".")[-2]))


def pin() -> None:
    """Adds today's whole message of each topic where the newest one is another."""
    MESSAGES.mkdir(parents=True, exist_ok=True)
    for topic in ALL_TOPICS:
        kept, today = pinned(topic), json.dumps(whole(topic), indent=1, ensure_ascii=False) + "\n"
        if not kept or kept[-1].read_text(encoding="utf-8") != today:
            (MESSAGES / f"{topic.name}.{len(kept) + 1}.json").write_text(today, encoding="utf-8")
