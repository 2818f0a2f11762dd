"""What is told on the bus: the AsyncAPI document is the code's own, and every message ever pinned is still read."""

import json
from typing import Any

import jsonschema_rs
import pytest
from api_messages import asyncapi, committed, differences, pinned, text_of, whole
from pydantic_asyncapi.v3 import AsyncAPI

from contracts.topics import ALL_TOPICS

TOPICS = pytest.mark.parametrize("topic", ALL_TOPICS, ids=lambda one: one.name)


def test_the_committed_document_is_the_codes_own() -> None:
    document = asyncapi()
    assert differences(document) == ([], []), "`make api` writes it"
    assert text_of(document) == text_of(committed())


def test_the_document_is_async_api() -> None:
    read = AsyncAPI.model_validate(committed())
    assert read.asyncapi == "3.0.0"
    assert read.channels is not None
    assert set(read.channels) == {topic.name for topic in ALL_TOPICS}


def test_everything_the_document_refers_to_is_in_it() -> None:
    document = committed()
    assert [ref for ref in _refs(document) if _at(document, ref) is None] == []


def test_every_operation_has_a_service_and_every_channel_one_that_tells() -> None:
    told = [one["channel"]["$ref"] for one in committed()["operations"].values() if one["action"] == "send"]
    assert sorted(told) == sorted(f"#/channels/{topic.name}" for topic in ALL_TOPICS)


@TOPICS
def test_every_pinned_message_is_still_read(topic: Any) -> None:
    assert pinned(topic) != []
    for path in pinned(topic):
        topic.decode(path.read_bytes())


@TOPICS
def test_todays_whole_message_is_pinned_and_is_as_the_document_says(topic: Any) -> None:
    today, document = whole(topic), committed()
    assert json.loads(pinned(topic)[-1].read_text(encoding="utf-8")) == today, "`make api` pins it"
    schema = document["components"]["messages"][topic.message.__name__]["payload"]
    validator = jsonschema_rs.validator_for({**schema, "components": document["components"]})
    assert [str(error) for error in validator.iter_errors(today | {"traceparent": "00-a-b-01"})] == []
    assert set(schema["properties"]) == set(today) | {"traceparent"}


def test_a_message_that_can_be_read_no_more_says_whom_it_breaks() -> None:
    document = asyncapi()
    goal = document["components"]["messages"]["Goal"]["payload"]
    goal["required"] = [*goal["required"], "tries"]
    goal["properties"] |= {"tries": {"type": "integer"}}
    breaking, besides = differences(document)
    assert breaking == [
        "robot.navigation: a message said before is not understood: `tries` may be missing. "
        "It breaks coordinator, ui, robot_bridge."
    ]
    assert besides == [
        "robot.navigation: a message said now is not understood before: `tries` is not known. "
        "It breaks coordinator, ui, robot_bridge of the release before."
    ]


def _refs(node: Any) -> list[str]:
    if isinstance(node, dict):
        own = [node["$ref"]] if isinstance(node.get("$ref"), str) else []
        return own + [ref for value in node.values() for ref in _refs(value)]
    return [ref for value in node for ref in _refs(value)] if isinstance(node, list) else []


def _at(document: Any, ref: str) -> Any:
    for part in ref.removeprefix("#/").split("/"):
        document = document.get(part, {})
    return document or None
