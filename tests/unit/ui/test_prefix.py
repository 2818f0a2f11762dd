"""What a proxy says of the path it serves the page below."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ui.prefix import prefix_of


@pytest.mark.parametrize(
    ("said", "prefix"),
    [
        ([], ""),
        ([""], ""),
        (["/"], ""),
        (["/robot"], "/robot"),
        (["/robot/"], "/robot"),
        (["robot"], "/robot"),
        (["/home//robot"], "/home/robot"),
        (["/home/robot///"], "/home/robot"),
        (["/home", "/robot"], "/home/robot"),
        (["/home, /robot"], "/home/robot"),
        (["/api/hassio_ingress/Xb9-_k~Q"], "/api/hassio_ingress/Xb9-_k~Q"),
        (["/user@v1.2"], "/user@v1.2"),
    ],
)
def test_a_path_is_read_however_its_slashes_are_set(said: list[str], prefix: str) -> None:
    assert prefix_of(said) == prefix


@pytest.mark.parametrize(
    "said",
    [
        "//evil",
        "//evil.example/robot",
        "/robot,//evil",
        "http://evil.example",
        "/robot/../admin",
        "/..",
        "/./robot",
        "/.hidden",
        "/robot%2f..",
        "/robot\\evil",
        "/robot?x=1",
        "/robot#x",
        "/ro bot",
        '/"><script>alert(1)</script>',
        "/';alert(1)//",
        "/robot\r\nSet-Cookie: a=b",
        "/robot\x00",
        "/röbot",
        "javascript:alert(1)",
        f"/{'x' * 300}",
    ],
)
def test_what_is_no_plain_path_of_this_host_is_not_believed(said: str) -> None:
    assert prefix_of([said]) is None


@given(st.lists(st.text(max_size=40), max_size=3))
def test_whatever_is_said_an_address_below_it_stays_on_this_host_and_needs_no_quoting(said: list[str]) -> None:
    prefix = prefix_of(said) or ""
    assert not prefix.startswith("//")
    assert not prefix.endswith("/")
    assert ".." not in prefix.split("/")
    assert set(prefix).isdisjoint("<>\"'\\%?#& \r\n")
