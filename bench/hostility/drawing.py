"""Requests drawn from a service's OpenAPI document, sensible and senseless; the same in every run of one seed."""

import json
import random
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final
from urllib.parse import quote

Schema = Mapping[str, Any]
DEPTH_MAX: Final = 6
METHODS: Final = ("GET", "POST", "PUT", "DELETE", "PATCH", "OPTIONS", "HEAD", "TRACE", "QUERY")
HOSTILE_VALUES: Final[tuple[Any, ...]] = (
    None, True, -1, 0, 2**31, 2**63, -(2**64), 10**400, 1e308, -1e-320, float("nan"), float("inf"), "",
    "\x00", "\ud800", "'; DROP TABLE objects; --", "../../etc/passwd", "%00", "🤖" * 200, "a" * 5000, [], {}, [[[[]]]],
    {"": {}}, [None] * 300,
)  # fmt: skip


@dataclass(frozen=True)
class Request:
    method: str
    path: str
    headers: Mapping[str, str] = field(default_factory=dict[str, str])
    body: bytes = b""


class Document:
    """One service's OpenAPI document, or the JSON schema of one message."""

    def __init__(self, document: Schema, chance: random.Random) -> None:
        self._document = document
        self._chance = chance
        self._operations = [
            (method.upper(), path, operation)
            for path, methods in document.get("paths", {}).items()
            for method, operation in methods.items()
        ]

    def request(self) -> Request:
        """One operation with every part drawn; each part may be hostile."""
        method, path, operation = self._chance.choice(self._operations)
        query = list[str]()
        headers = dict[str, str]()
        for parameter in operation.get("parameters", ()):
            value = quote(_plain(self.value(parameter.get("schema", {}))), safe="")
            if parameter["in"] == "path":
                path = path.replace(f"{{{parameter['name']}}}", value or "0")
            elif parameter["in"] == "header":
                headers[parameter["name"]] = value
            elif parameter.get("required") or self._chance.random() < 0.5:
                query.append(f"{parameter['name']}={value}")
        body = b""
        contents = operation.get("requestBody", {}).get("content", {})
        if contents:
            kind, content = self._chance.choice(list(contents.items()))
            headers["Content-Type"] = kind
            drawn = self.value(content.get("schema", {}))
            body = (
                json.dumps(drawn).encode() if "json" in kind else _plain(drawn).encode("utf-8", "surrogatepass")[:10000]
            )
        if self._chance.random() < 0.05:
            method = self._chance.choice(METHODS)
        return Request(method, path + ("?" + "&".join(query) if query else ""), headers, body)

    def value(self, schema: Schema, depth: int = 0) -> Any:
        """As the schema has it, but in one of twenty places something else."""
        if depth > DEPTH_MAX or self._chance.random() < 0.05:
            return self._chance.choice(HOSTILE_VALUES)
        if "$ref" in schema:
            return self.value(self._resolved(schema["$ref"]), depth + 1)
        for either in ("anyOf", "oneOf", "allOf"):
            if schema.get(either):
                return self.value(self._chance.choice(schema[either]), depth + 1)
        if "const" in schema:
            return schema["const"]
        if "enum" in schema:
            return self._chance.choice(schema["enum"])
        return self._of_type(schema, depth)

    def _of_type(self, schema: Schema, depth: int) -> Any:
        kind = schema.get("type")
        if kind == "object":
            return {
                name: self.value(each, depth + 1)
                for name, each in schema.get("properties", {}).items()
                if name in schema.get("required", ()) or self._chance.random() < 0.7
            }
        if kind == "array":
            fewest = schema.get("minItems", 0)
            count = self._chance.randint(fewest, max(fewest, min(schema.get("maxItems", 4), 4)))
            several = schema.get("prefixItems") or [schema.get("items", {})] * count
            return [self.value(each, depth + 1) for each in several]
        if kind in {"number", "integer"}:
            low, high = schema.get("minimum", -100), schema.get("maximum", 100)
            drawn = self._chance.uniform(low, max(low, high))
            return round(drawn) if kind == "integer" else drawn
        if kind == "boolean":
            return self._chance.random() < 0.5
        if kind == "null":
            return None
        return self._chance.choice(("none", "bottle", "kitchen", "find the red bottle", "0", "é\u202e", "x" * 40))

    def _resolved(self, reference: str) -> Schema:
        found: Any = self._document
        for part in reference.removeprefix("#/").split("/"):
            found = found[part]
        return found


def _plain(value: Any) -> str:
    return (value if isinstance(value, str) else json.dumps(value)).encode("utf-8", "replace").decode()[:2000]
