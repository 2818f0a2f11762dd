"""Reads what a language model answered: its form leniently, its content as the schema says. Pure.

Models put fences, thoughts, prose, a list or a tool call round the JSON they were asked for. None of that says
anything; the fields do, and they are held to the schema here and to the words of the command in `claims`.
"""

import json
import re
from collections.abc import Iterator
from typing import Any, TypeVar, cast

from pydantic import ValidationError

from inference.language.prompts import Answer
from inference.ports import Completion, Ending

A = TypeVar("A", bound=Answer)

TEXT_MAX = 20_000
"""Characters looked at."""
QUOTED_MAX = 60
"""Characters of an answer that are told of it."""
THOUGHTS = re.compile(r"[<\[](think(?:ing)?|thoughts?|reasoning)[>\]].*?([<\[]/\1[>\]]|\Z)", re.DOTALL | re.IGNORECASE)
UNOPENED_THOUGHTS = re.compile(r"\A.*[<\[]/(?:think(?:ing)?|thoughts?|reasoning)[>\]]", re.DOTALL | re.IGNORECASE)
"""Some servers put the opening tag into the prompt."""
TYPOGRAPHIC = str.maketrans("\u201c\u201d\u201e\u201f", '""""')
CALLS = ("function", "arguments", "parameters")
"""What a tool call, written down as text, wraps its fields in."""

_decoder = json.JSONDecoder()


class WrongAnswerError(Exception):
    """An answer nobody can use; the text says why."""


def read(said: Completion, kind: type[A]) -> A:
    """The one answer in what was said. Raises `WrongAnswerError`."""
    if said.ending is Ending.REFUSED:
        raise WrongAnswerError(f"it refused: {_quoted(said.text)}")
    text = _spoken(said)
    found, wrong = _answers(text, kind)
    if len(found) == 1:
        return found[0]
    if found:
        raise WrongAnswerError("gave several answers that differ")
    raise WrongAnswerError(wrong or _nothing_in(text, said))


def _spoken(said: Completion) -> str:
    """The text without its thoughts. Thoughts that are one JSON object are an answer that its server misplaced."""
    text = said.text[:TEXT_MAX]
    if not _is_object(text):
        text = UNOPENED_THOUGHTS.sub("", THOUGHTS.sub("", text))
    return text if text.strip() or not _is_object(said.thoughts) else said.thoughts


def _is_object(text: str) -> bool:
    try:
        return isinstance(json.loads(text[:TEXT_MAX]), dict)
    except (ValueError, RecursionError):
        return False


def _answers(text: str, kind: type[A]) -> tuple[list[A], str]:
    """Every different answer in it, and what is wrong with the first that is none."""
    found: list[A] = []
    wrong = ""
    for fields in [*_objects(text)] or [*_objects(text.translate(TYPOGRAPHIC))]:
        try:
            answer = kind.model_validate(_unwrapped(fields, kind))
        except ValidationError as error:
            wrong = wrong or f"answered outside the schema: {_first_of(error)}"
        else:
            found += [answer] if answer not in found else []
    plain = None if found or wrong else kind.said_plainly(text)
    return ([plain] if plain is not None else found), wrong


def _objects(text: str) -> Iterator[dict[str, Any]]:
    """The JSON objects in a text, in their order; those inside of another are not told apart."""
    at = text.find("{")
    while at >= 0:
        try:
            value, end = _decoder.raw_decode(text, at)
        except (ValueError, RecursionError):
            end = at + 1
        else:
            yield value
        at = text.find("{", end)


def _unwrapped(fields: dict[str, Any], kind: type[Answer]) -> dict[str, Any]:
    """The fields of a tool call, or of the only object in an object."""
    if any(name.lower() in kind.model_fields for name in fields):
        inner = None if len(fields) > 1 else next(iter(fields.values()))
    elif any(key in fields for key in CALLS):
        inner = next(fields[key] for key in CALLS if key in fields)
        inner = next(_objects(inner), None) if isinstance(inner, str) else inner
    else:
        inner = next(iter(fields.values())) if len(fields) == 1 else None
    return _unwrapped(cast(dict[str, Any], inner), kind) if isinstance(inner, dict) else fields


def _first_of(error: ValidationError) -> str:
    first = error.errors(include_url=False, include_context=False, include_input=False)[0]
    return f"{'.'.join(str(part) for part in first['loc'])}: {first['msg']}"


def _nothing_in(text: str, said: Completion) -> str:
    cut_off = said.ending is Ending.CUT_OFF
    if text.strip():
        return f"its answer was cut off: {_quoted(text)}" if cut_off else f"no JSON in its answer: {_quoted(text)}"
    if said.thoughts.strip() or said.text.strip():
        return f"it thought aloud and gave no answer{', its tokens were used up' if cut_off else ''}"
    return "its answer was empty" + (", its tokens were used up" if cut_off else "")


def _quoted(text: str) -> str:
    plain = " ".join(text.split())
    return repr(plain if len(plain) <= QUOTED_MAX else f"{plain[: QUOTED_MAX - 1]}…")
