"""What a change of an OpenAPI document breaks, found by comparing the old document with the new one.

One rule decides: whatever a caller of the old document may send the new one must take, and whatever the new one
answers a reader of the old one must understand.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Final

from contracts.access import Role

Schema = Mapping[str, Any]

METHODS: Final = ("get", "put", "post", "delete", "patch", "head", "options")
LEAST: Final = ("minimum", "exclusiveMinimum", "minLength", "minItems", "minProperties")
MOST: Final = ("maximum", "exclusiveMaximum", "maxLength", "maxItems", "maxProperties")
ANYTHING: Final[Schema] = {}


@dataclass(frozen=True)
class Change:
    """`added` is what only readers of the release before trip over: they refuse a field that they do not know."""

    operation: str
    text: str
    added: bool = False


class Kind(StrEnum):
    MISSING = "a field may be absent that has to be there"
    GONE = "a field that may be there never is"
    UNKNOWN = "a field may be there that is not known"
    OTHER = "a value may be another than it has to be"


@dataclass(frozen=True)
class Gap:
    """A place where one schema allows what the other does not."""

    path: str
    text: str = ""
    kind: Kind = Kind.OTHER


OF_BODY: Final = {
    Kind.MISSING: "needs `{}` in its body now",
    Kind.UNKNOWN: "no longer takes `{}` in its body",
    Kind.OTHER: "takes less in its body: `{}` {}",
}
OF_ANSWER: Final = {
    Kind.MISSING: "no longer always answers `{}`",
    Kind.GONE: "no longer answers `{}`",
    Kind.UNKNOWN: "answers `{}` besides, and who forbids unknown fields refuses it",
    Kind.OTHER: "answers something else: `{}` {}",
}


def changes(old: Schema, new: Schema) -> list[Change]:
    """Every change between two documents of one service that a caller may notice; operations are 'POST /recall'."""
    found: list[Change] = []
    now = dict(operations(new))
    for name, before in operations(old):
        if name not in now:
            found.append(Change(name, "is gone"))
        else:
            found += [Change(name, *told) for told in _operation(before, now[name], old, new)]
    return list(dict.fromkeys(found))


def operations(document: Schema) -> Iterator[tuple[str, Schema]]:
    """('POST /recall', its operation), with the parameters of the whole path among its own."""
    for path, item in document["paths"].items():
        for method in METHODS:
            if method in item:
                shared = {"parameters": [*item.get("parameters", []), *item[method].get("parameters", [])]}
                yield f"{method.upper()} {path}", {**item[method], **shared}


def _operation(before: Schema, after: Schema, old: Schema, new: Schema) -> Iterator[tuple[str] | tuple[str, bool]]:
    role, role_before = after.get("x-required-role"), before.get("x-required-role")
    if role is not None and (role_before is None or not Role(role_before).may(Role(role))):
        yield (f"asks for the role {role} now",)
    elif after.get("security") and not before.get("security") and role == role_before:
        yield ("asks for a key now",)
    yield from _parameters(before, after, old, new)
    yield from _request(before.get("requestBody", {}), after.get("requestBody", {}), old, new)
    yield from _responses(before["responses"], after["responses"], old, new)


def _parameters(before: Schema, after: Schema, old: Schema, new: Schema) -> Iterator[tuple[str]]:
    had = {(one["in"], one["name"]): one for one in before["parameters"]}
    has = {(one["in"], one["name"]): one for one in after["parameters"]}
    for (place, name), one in has.items():
        known = had.get((place, name), {})
        if one.get("required") and not known.get("required"):
            yield (f"needs the {place} parameter `{name}` now",)
        for gap in accepts(one.get("schema", ANYTHING), known.get("schema", ANYTHING), new, old) if known else ():
            yield (f"takes less as the {place} parameter `{name}`: {gap.text}",)
    for place, name in had.keys() - has.keys():
        yield (f"no longer reads the {place} parameter `{name}`",)


def _request(before: Schema, after: Schema, old: Schema, new: Schema) -> Iterator[tuple[str]]:
    if after.get("required") and not before.get("required"):
        yield ("needs a body now",)
    for kind, content in before.get("content", {}).items():
        if kind not in after.get("content", {}):
            yield (f"no longer takes a body of {kind}",)
            continue
        asked = after["content"][kind].get("schema", ANYTHING)
        for gap in accepts(asked, content.get("schema", ANYTHING), new, old):
            if gap.kind in OF_BODY:
                yield (OF_BODY[gap.kind].format(gap.path or "all", gap.text),)


def _responses(before: Schema, after: Schema, old: Schema, new: Schema) -> Iterator[tuple[str] | tuple[str, bool]]:
    for status, answer in before.items():
        if not status.startswith("2"):
            continue
        if status not in after:
            yield (f"no longer answers {status}",)
            continue
        for kind, content in answer.get("content", {}).items():
            if kind not in after[status].get("content", {}):
                yield (f"no longer answers with {kind}",)
                continue
            given = after[status]["content"][kind].get("schema", ANYTHING)
            for gap in accepts(content.get("schema", ANYTHING), given, old, new):
                yield (OF_ANSWER[gap.kind].format(gap.path or "all", gap.text), gap.kind is Kind.UNKNOWN)


def accepts(
    wide: Schema,
    narrow: Schema,
    wide_root: Schema,
    narrow_root: Schema,
    path: str = "",
    seen: frozenset[str] = frozenset(),
) -> list[Gap]:
    """Where a value that `narrow` allows may not be one that `wide` allows; empty where every one is."""
    pair = f"{wide.get('$ref')} {narrow.get('$ref')}"
    if pair in seen:
        return []
    seen = seen | {pair} if "$ref" in wide and "$ref" in narrow else seen
    wides, narrows = list(_kinds(wide, wide_root)), list(_kinds(narrow, narrow_root))
    found: list[Gap] = []
    for one in narrows:
        tries = [_kind(other, one, wide_root, narrow_root, path, seen) for other in wides]
        found += min(
            tries, key=lambda gaps: (any(gap.path == path and gap.kind is Kind.OTHER for gap in gaps), len(gaps))
        )
    return found


def _kinds(schema: Schema, root: Schema) -> Iterator[Schema]:
    """The alternatives of a schema, each with one type and no reference."""
    if "$ref" in schema:
        target: Schema = root
        for part in schema["$ref"].removeprefix("#/").split("/"):
            target = target[part]
        yield from _kinds(target, root)
    elif branches := schema.get("anyOf") or schema.get("oneOf") or schema.get("allOf"):
        for branch in branches:
            yield from _kinds(branch, root)
    elif isinstance(types := schema.get("type"), list):
        for one in types:
            yield {**schema, "type": one}
    else:
        yield schema


def _kind(
    wide: Schema, narrow: Schema, wide_root: Schema, narrow_root: Schema, path: str, seen: frozenset[str]
) -> list[Gap]:
    may, does = wide.get("type"), narrow.get("type")
    if may is not None and may != does and (may, does) != ("number", "integer"):
        return [Gap(path, f"may be {_name(narrow)} where it has to be {_name(wide)}")]
    found = [Gap(path, f"may be {value!r}") for value in _beyond(wide, narrow)]
    found += [
        Gap(path, f"may have {key} {narrow.get(key, 'none')} where it has to be {wide[key]}")
        for key in _looser(wide, narrow)
    ]
    if does == "object":
        found += _fields(wide, narrow, wide_root, narrow_root, path, seen)
    if does == "array":
        for inner, other in _items(wide, narrow):
            found += accepts(inner, other, wide_root, narrow_root, f"{path}[]", seen)
    return found


def _name(schema: Schema) -> str:
    return str(schema.get("type", "anything"))


def _beyond(wide: Schema, narrow: Schema) -> list[Any]:
    may = wide.get("enum", [wide["const"]] if "const" in wide else None)
    does = narrow.get("enum", [narrow["const"]] if "const" in narrow else None)
    if may is None:
        return []
    return ["anything"] if does is None else [value for value in does if value not in may]


def _looser(wide: Schema, narrow: Schema) -> list[str]:
    """The bounds of `wide` that `narrow` does not keep."""
    least = [key for key in LEAST if key in wide and narrow.get(key, float("-inf")) < wide[key]]
    most = [key for key in MOST if key in wide and narrow.get(key, float("inf")) > wide[key]]
    other = [key for key in ("pattern", "format") if key in wide and narrow.get(key) != wide[key]]
    return least + most + other


def _fields(
    wide: Schema, narrow: Schema, wide_root: Schema, narrow_root: Schema, path: str, seen: frozenset[str]
) -> list[Gap]:
    may, does = wide.get("properties", {}), narrow.get("properties", {})
    must, always = set(wide.get("required", [])), set(narrow.get("required", [])) & set(does)
    found = [Gap(_in(path, name), kind=Kind.MISSING) for name in may if name in must - always]
    found += [Gap(_in(path, name), kind=Kind.GONE) for name in may if name not in {*must, *does}]
    for name, schema in does.items():
        if name in may:
            found += accepts(may[name], schema, wide_root, narrow_root, _in(path, name), seen)
        elif wide.get("additionalProperties") is False:
            found.append(Gap(_in(path, name), kind=Kind.UNKNOWN))
    rest, other = wide.get("additionalProperties"), narrow.get("additionalProperties")
    if isinstance(rest, dict) and isinstance(other, dict):
        found += accepts(rest, other, wide_root, narrow_root, _in(path, "*"), seen)
    return found


def _in(path: str, name: str) -> str:
    return f"{path}.{name}" if path else name


def _items(wide: Schema, narrow: Schema) -> Iterator[tuple[Schema, Schema]]:
    firsts, others = wide.get("prefixItems", []), narrow.get("prefixItems", [])
    for number in range(max(len(firsts), len(others), 1)):
        yield (
            firsts[number] if number < len(firsts) else wide.get("items") or ANYTHING,
            others[number] if number < len(others) else narrow.get("items") or ANYTHING,
        )
