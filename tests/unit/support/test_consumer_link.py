"""What counts as the same answer: a value that no example shows does not."""

from typing import Any

import pytest

from support.consumer_link import lacking


@pytest.mark.parametrize(
    ("example", "answered"),
    [
        ({"a": 1}, {"a": 2.5, "b": "new"}),
        ({"a": None}, {"a": None}),
        ({"a": []}, {"a": []}),
        ({"a": [1]}, {"a": [2, 3]}),
        ([{"a": None}, {"a": 1}], [{"a": 3}]),
        ([{"a": 1, "b": 1}, {"a": 1}], [{"a": 1}]),
        ({"looked_share": None}, {"looked_share": 0.2}),
        ({"looked_share": 0.2}, {"looked_share": None}),
    ],
)
def test_like_the_example(example: Any, answered: Any) -> None:
    assert list(lacking(example, answered)) == []


@pytest.mark.parametrize(
    ("example", "answered", "said"),
    [
        ({"a": 1}, {}, "a is missing"),
        ({"a": {"b": None}}, {"a": {"b": "x"}}, "a.b is string, not null"),
        ({"a": "x"}, {"a": None}, "a is null, not string"),
        ({"a": 1}, {"a": True}, "a is boolean, not number"),
        ({"a": []}, {"a": [1]}, "a is not empty"),
        ({"a": [1]}, {"a": []}, "a is empty"),
        ({"a": [1]}, {"a": ["x"]}, "a[] is string, not number"),
        ({"a": {}}, {"a": []}, "a is list, not object"),
        ({"looked_share": 0.2}, {"looked_share": "x"}, "looked_share is string, not number"),
        ([{"a": 1}, {"a": None}], [{"a": "x"}], "[].a is string, not null or number"),
        ([{"a": 1, "b": 1}, {"a": 1}], [{"b": 1}], "[].a is missing"),
    ],
)
def test_unlike_the_example(example: Any, answered: Any, said: str) -> None:
    assert list(lacking(example, answered)) == [said]
