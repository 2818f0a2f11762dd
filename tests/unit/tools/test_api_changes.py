"""A change of a document is told as what it breaks, and as nothing where it breaks nobody."""

from typing import Any

import pytest
from api_changes import Change, changes

THING = {
    "type": "object",
    "additionalProperties": False,
    "properties": {
        "label": {"type": "string", "maxLength": 64},
        "state": {"enum": ["there", "gone"], "type": "string"},
        "place": {"anyOf": [{"$ref": "#/components/schemas/Place"}, {"type": "null"}]},
    },
    "required": ["label", "state", "place"],
}
PLACE = {
    "type": "object",
    "properties": {"xy": {"type": "array", "prefixItems": [{"type": "number"}, {"type": "number"}]}},
    "required": ["xy"],
}


def document(
    thing: dict[str, Any] | None = None, place: dict[str, Any] | None = None, **of_route: Any
) -> dict[str, Any]:
    """One route that takes a thing and answers with one."""
    content = {"application/json": {"schema": {"$ref": "#/components/schemas/Thing"}}}
    route = {
        "parameters": [{"in": "query", "name": "limit", "schema": {"type": "integer", "maximum": 100}}],
        "requestBody": {"content": content},
        "responses": {"200": {"content": content}},
    }
    return {
        "paths": {"/things": {"post": route | of_route}},
        "components": {"schemas": {"Thing": thing or THING, "Place": place or PLACE}},
    }


def with_field(name: str, schema: dict[str, Any], *, required: bool = False) -> dict[str, Any]:
    names = [*THING["required"], name] if required else THING["required"]
    return {**THING, "properties": {**THING["properties"], name: schema}, "required": names}


def without_field(name: str) -> dict[str, Any]:
    kept = {key: value for key, value in THING["properties"].items() if key != name}
    return {**THING, "properties": kept, "required": [key for key in THING["required"] if key != name]}


@pytest.mark.parametrize(
    "new",
    [
        document(),
        document(thing={**THING, "title": "Thing", "description": "what stands about"}),
        document(parameters=[{"in": "query", "name": "limit", "schema": {"type": "number", "maximum": 900}}]),
    ],
)
def test_what_breaks_nobody_is_not_told(new: dict[str, Any]) -> None:
    assert changes(document(), new) == []


@pytest.mark.parametrize(
    ("before", "after", "told"),
    [
        ("operator", "viewer", []),
        ("admin", "operator", []),
        ("viewer", None, []),
        ("viewer", "operator", ["asks for the role operator now"]),
        (None, "viewer", ["asks for the role viewer now"]),
    ],
)
def test_a_higher_role_breaks_its_callers_and_a_lower_one_nobody(
    before: str | None, after: str | None, told: list[str]
) -> None:
    changed = changes(document(**{"x-required-role": before}), document(**{"x-required-role": after}))
    assert [one.text for one in changed] == told


ANSWER = "answers something else:"


@pytest.mark.parametrize(
    ("new", "told"),
    [
        ({"paths": {}}, "is gone"),
        (document(without_field("label")), "no longer always answers `label`"),
        (document(without_field("label")), "no longer takes `label` in its body"),
        (
            document(with_field("why", {"type": "string"}, required=True)),
            "needs `why` in its body now",
        ),
        (document(with_field("label", {"type": "integer"})),
         f"{ANSWER} `label` may be integer where it has to be string"),
        (document(with_field("label", {"type": "string"})),
         f"{ANSWER} `label` may have maxLength none where it has to be 64"),
        (
            document(with_field("label", {"type": "string", "maxLength": 9})),
            "takes less in its body: `label` may have maxLength 64 where it has to be 9",
        ),
        (
            document(with_field("state", {"type": "string", "enum": ["there", "gone", "lost"]})),
            f"{ANSWER} `state` may be 'lost'",
        ),
        (document(with_field("place", {"$ref": "#/components/schemas/Place"})),
         "takes less in its body: `place` may be null where it has to be object"),
        (
            document(place={**PLACE, "properties": {"xy": {"type": "array", "items": {"type": "string"}}}}),
            f"{ANSWER} `place.xy[]` may be string where it has to be number",
        ),
        (document(parameters=[]), "no longer reads the query parameter `limit`"),
        (
            document(parameters=[{"in": "query", "name": "limit", "schema": {"type": "integer", "maximum": 50}}]),
            "takes less as the query parameter `limit`: may have maximum 100 where it has to be 50",
        ),
        (
            document(parameters=[{"in": "query", "name": "home", "required": True, "schema": {"type": "string"}}]),
            "needs the query parameter `home` now",
        ),
        (document(responses={"204": {}}), "no longer answers 200"),
        (document(responses={"200": {"content": {"text/plain": {}}}}), "no longer answers with application/json"),
        (document(**{"x-required-role": "operator"}), "asks for the role operator now"),
        (document(security=[{"key": []}]), "asks for a key now"),
    ],
)  # fmt: skip
def test_what_breaks_a_caller_is_told(new: dict[str, Any], told: str) -> None:
    assert Change("POST /things", told) in changes(document(), new)


def test_a_new_field_is_told_as_what_readers_of_the_release_before_refuse() -> None:
    told = changes(document(), document(with_field("colour", {"type": "string"})))
    text = "answers `colour` besides, and who forbids unknown fields refuses it"
    assert told == [Change("POST /things", text, added=True)]


def test_what_refers_to_itself_comes_to_an_end() -> None:
    nested = {"type": "object", "properties": {"inner": {"$ref": "#/components/schemas/Thing"}}}
    assert changes(document(nested), document(nested)) == []


def test_a_field_that_need_not_be_there_and_never_is_breaks_who_reads_it() -> None:
    before = document(with_field("why", {"type": "string"}))
    assert Change("POST /things", "no longer answers `why`") in changes(before, document())
