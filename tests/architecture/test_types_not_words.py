"""Programs talk in types: nothing branches on what a sentence for a person says."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from support.source import ROOT

PLACES = ("services", "packages", "bench", "demo", "sim")
SENTENCES = frozenset({"reason", "detail", "error_msg", "stop_reason", "progress", "text"})
"""Fields and variables that hold a sentence."""
READS_PEOPLE = (
    "packages/vocabulary",
    "packages/ear/src/ear/choices.py",
    "packages/ear/src/ear/words.py",
    "services/inference",
    "services/coordinator/src/coordinator/queue/parse_validation.py",
    "services/coordinator/src/coordinator/questions/parsed_question.py",
    "services/memory/src/memory/recall.py",
    "services/ui/src/ui/panels/memory_panel.py",
    "sim/src/sim/training",
)
"""What a person said is read there: a `text` of theirs is no sentence of ours."""
LOOKS_INTO = frozenset({
    "startswith", "endswith", "find", "rfind", "index", "count", "removeprefix", "removesuffix", "split", "partition",
})  # fmt: skip
SEARCHES = frozenset({"search", "match", "fullmatch", "findall", "finditer"})


def readings(tree: ast.AST, sentences: frozenset[str]) -> Iterator[int]:
    """Lines on which a program looks into a sentence, or compares it with a word."""
    for node in ast.walk(tree):
        match node:
            case ast.Compare(left=left, ops=ops, comparators=right):
                sides = [left, *right]
                for op, before, after in zip(ops, sides[:-1], sides[1:], strict=True):
                    looks = isinstance(op, ast.In | ast.NotIn) and _is_sentence(after, sentences)
                    either = _is_sentence(before, sentences) or _is_sentence(after, sentences)
                    if looks or (either and (_is_word(before) or _is_word(after) or isinstance(op, ast.In))):
                        yield node.lineno
            case ast.Call(func=ast.Attribute(value=value, attr=attr)) if attr in LOOKS_INTO:
                if _is_sentence(value, sentences):
                    yield node.lineno
            case ast.Call(func=ast.Attribute(attr=attr), args=[_, value, *_]) if attr in SEARCHES:
                if _is_sentence(value, sentences):
                    yield node.lineno
            case ast.Match(subject=subject) if _is_sentence(subject, sentences):
                yield node.lineno
            case _:
                pass


def _is_sentence(node: ast.expr, sentences: frozenset[str]) -> bool:
    match node:
        case ast.Name(id=name):  # a local text may be anything
            return name in sentences - {"text"}
        case ast.Attribute(attr=name) | ast.Subscript(slice=ast.Constant(value=str(name))):
            return name in sentences
        case ast.Call(func=ast.Attribute(value=value, attr="lower" | "strip" | "casefold" | "upper")):
            return _is_sentence(value, sentences)
        case ast.Call(func=ast.Name(id="str"), args=[value]):
            return _is_sentence(value, sentences)
        case _:
            return False


def _is_word(node: ast.expr) -> bool:
    """Text that is written down in the program; '' asks only whether there is a sentence at all."""
    match node:
        case ast.Constant(value=str(text)):
            return text != ""
        case ast.Name(id=name) | ast.Attribute(attr=name):
            return name.isupper()
        case _:
            return False


def test_nothing_branches_on_what_a_sentence_says() -> None:
    found: list[str] = []
    for path in sorted(one for place in PLACES for one in (ROOT / place).rglob("*.py")):
        name = str(path.relative_to(ROOT))
        if ".venv" in name:
            continue
        sentences = SENTENCES - {"text"} if name.startswith(READS_PEOPLE) else SENTENCES
        found += [f"{name}:{line}" for line in readings(_tree(path), sentences)]
    assert found == []


@pytest.mark.parametrize(
    "program",
    [
        "if 'stop' in reply.reason: pass",
        "if 'stop' not in reason: pass",
        "any(word in reply.detail for word in WORDS)",
        "if mission.reason == STOP_WORDS: pass",
        "if reply['reason'] == 'timeout': pass",
        "if event.reason in {'timeout', 'blocked'}: pass",
        "if error.detail.startswith('no session'): pass",
        "if str(reply['reason']).lower().startswith('the epoch'): pass",
        "share = re.search(PATTERN, mission.reason)",
        "words = reply.error_msg.split()",
        "match reply.text:\n    case 'done': pass",
    ],
)
def test_every_way_of_reading_a_sentence_is_seen(program: str) -> None:
    assert list(readings(ast.parse(program), SENTENCES))


@pytest.mark.parametrize(
    "program",
    [
        "if not reply.reason: pass",
        "if reason == '': pass",
        "say(f'it ended: {reply.reason}')",
        "if a.reason != b.reason: pass",
    ],
)
def test_telling_a_sentence_on_is_no_reading_of_it(program: str) -> None:
    assert not list(readings(ast.parse(program), SENTENCES))


def _tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))
