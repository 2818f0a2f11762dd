"""Reads a command by rules: which COCO class is meant, where to look first, and in which words. Pure; never raises.

Every name in the command is found (longest first, plurals and small typos included). Names behind a word of place
("on the table") or a negation ("not the cup") are context. The first run of names that are not is what is wanted;
its last name is the head ("coffee *table*"). The description is made of the head and the attributes said with it:
no word is added that nobody said.
"""

import re
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass

from contracts.vision import ParsedTask, ParseTaskRequest
from inference.colours import SPELLINGS
from inference.lexicon import Lexicon, correction, lexicon, singular_forms

PARSER = "rules"
TOKENS_MAX = 120
DESCRIPTION_WORDS_MAX = 4
ARTICLES = frozenset(("the", "a", "an", "my", "our", "your", "this", "that", "his", "her", "of", "any"))
PARTS = frozenset(("front", "top", "side", "middle", "corner", "edge"))
"""'in front of the tv', 'on top of the table'."""


@dataclass(frozen=True, slots=True)
class Mention:
    """A name found in the command: tokens `start` to `end` (exclusive)."""

    start: int
    end: int
    label: str
    said: str
    corrected: bool = False
    context: bool = False
    negated: bool = False


def parse(request: ParseTaskRequest) -> ParsedTask:
    """What the command means, as far as the rules can tell; `yolo_class` is 'none' when nothing known is named."""
    words = lexicon()
    tokens = tokenize(request.command)
    mentions = mark_context(tokens, find_mentions(tokens, words), words)
    head = pick_head(tokens, mentions, words)
    needed = find_need(tokens, words, request.labels_in_memory) if head is None or head.label == "none" else None
    if needed is not None:
        return _answer(needed, needed, mentions, request, f"the need for a {needed} was read from the wording")
    if head is None:
        return ParsedTask(yolo_class="none", parser=PARSER, notes="names nothing the detector knows")
    if head.label == "none":
        return ParsedTask(yolo_class="none", parser=PARSER, notes=f"the detector knows no '{head.said}'")
    attributes = attributes_of(tokens, head, mentions, words)
    description = " ".join([*attributes, head.said])
    notes = f"'{' '.join(tokens[head.start : head.end])}' was read as '{head.said}'" if head.corrected else ""
    return _answer(head.label, description, mentions, request, notes)


def tokenize(command: str) -> list[str]:
    """Lower-case words without accents; at most 120."""
    plain = unicodedata.normalize("NFKD", command[:4000]).casefold()
    plain = "".join(c for c in plain if not unicodedata.combining(c)).replace("'", "").replace("\u2019", "")
    return re.findall(r"[a-z]+", plain)[:TOKENS_MAX]


def find_mentions(tokens: Sequence[str], words: Lexicon) -> list[Mention]:
    """Names from left to right, the longest at each place, none overlapping."""
    known = [_known_forms(token, words) for token in tokens]
    found: list[Mention] = []
    at = 0
    while at < len(tokens):
        mention = _longest_at(tokens, known, at, words)
        if mention is None:
            at += 1
        else:
            found.append(mention)
            at = mention.end
    return found


def _longest_at(tokens: Sequence[str], known: Sequence[tuple[str, ...]], at: int, words: Lexicon) -> Mention | None:
    for length in range(min(words.longest, len(tokens) - at), 0, -1):
        for said in _combinations(known[at : at + length]):
            name = words.names.get(said)
            if name is None:
                continue
            literal = tuple(tokens[at : at + length])
            plural = all(a == b or b in singular_forms(a) for a, b in zip(literal, said, strict=True))
            return Mention(at, at + length, name.label, " ".join(name.words), corrected=not plural)
    return None


def _combinations(forms: Sequence[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """Each way to read a run of tokens: literally where possible, else singular, else corrected."""
    runs: list[tuple[str, ...]] = [()]
    for options in forms:
        runs = [(*run, option) for run in runs for option in options][:16]
    return runs


def _known_forms(token: str, words: Lexicon) -> tuple[str, ...]:
    if token in words.vocabulary:
        return (token, *(form for form in singular_forms(token) if form in words.vocabulary))
    singulars = tuple(form for form in singular_forms(token) if form in words.vocabulary)
    if singulars:
        return singulars
    if token in words.never_corrected or any(form in words.never_corrected for form in singular_forms(token)):
        return (token,)
    forms = (token, *singular_forms(token))
    return (token, *(fixed for form in forms if (fixed := correction(form, words.correctable)) is not None))


def mark_context(tokens: Sequence[str], mentions: Sequence[Mention], words: Lexicon) -> list[Mention]:
    """The mentions, told apart: wanted, standing behind a word of place, or negated."""
    marked: list[Mention] = []
    for mention in mentions:
        before = _word_before(tokens, mention, marked, words)
        marked.append(
            Mention(
                mention.start,
                mention.end,
                mention.label,
                mention.said,
                mention.corrected,
                context=before in words.places,
                negated=before in words.negations,
            )
        )
    return marked


def _word_before(tokens: Sequence[str], mention: Mention, earlier: Sequence[Mention], words: Lexicon) -> str:
    """The word that governs a mention: what stands left of its articles, attributes, and joined names."""
    skipped = ARTICLES | words.attributes | words.colours
    at = mention.start - 1
    while at >= 0:
        joined = next((one for one in earlier if one.start <= at < one.end), None)
        if joined is not None and not ARTICLES.intersection(tokens[at + 1 : mention.start]):
            at = joined.start - 1
        elif joined is not None:
            return ""
        elif (tokens[at] in skipped and tokens[at] not in words.places) or tokens[at] in PARTS:
            at -= 1
        else:
            return tokens[at]
    return ""


def pick_head(tokens: Sequence[str], mentions: Sequence[Mention], words: Lexicon) -> Mention | None:
    """The name that says what is wanted; none when only context is known and something unknown is asked for."""
    wanted = [one for one in mentions if not one.context and not one.negated and not _is_adjective(tokens, one, words)]
    if wanted:
        head = wanted[0]
        for following in wanted[1:]:
            if following.start != head.end:
                break
            head = following
        return head
    placed = [one for one in mentions if one.context and not one.negated]
    if not placed or _asks_for_unknown(tokens, mentions, words):
        return None
    return placed[0]


def _is_adjective(tokens: Sequence[str], one: Mention, words: Lexicon) -> bool:
    """'orange' or 'glass' before another word of the thing; 'can' at the start of a question."""
    if one.end - one.start != 1:
        return False
    word = tokens[one.start]
    following = tokens[one.end] if one.end < len(tokens) else ""
    if word == "can":
        return following in words.fillers or following == ""
    if word not in words.colours and word not in words.attributes:
        return False
    if not following or following in words.fillers:
        return False
    forms = (following, *singular_forms(following), correction(following, words.correctable))
    return following in words.attributes | words.colours or any(form in words.vocabulary for form in forms)


def _asks_for_unknown(tokens: Sequence[str], mentions: Sequence[Mention], words: Lexicon) -> bool:
    named = {at for one in mentions for at in range(one.start, one.end)}
    plain = words.fillers | words.places | words.negations | words.attributes | words.colours
    return any(at not in named and token not in plain for at, token in enumerate(tokens))


def attributes_of(tokens: Sequence[str], head: Mention, mentions: Sequence[Mention], words: Lexicon) -> list[str]:
    """Colours, materials and sizes said of the head, in the order said, in the system's spelling of colours."""
    said: list[str] = []
    start = head.start - 1
    while start >= 0 and (
        tokens[start] in words.colours | words.attributes or tokens[start] in ("and", "coloured", "colored")
    ):
        if tokens[start] not in ("and", "coloured", "colored"):
            said.insert(0, tokens[start])
        start -= 1
    if not any(word in words.colours for word in said):
        said = [*_colour_after(tokens, head, mentions, words), *said]
    spelled = dict.fromkeys(SPELLINGS.get(word, word) for word in said)
    room = max(1, DESCRIPTION_WORDS_MAX - len(head.said.split()))
    return list(spelled)[-room:]


def _colour_after(tokens: Sequence[str], head: Mention, mentions: Sequence[Mention], words: Lexicon) -> list[str]:
    named = {at for one in mentions for at in range(one.start, one.end) if one.label != "orange"}
    for at in range(head.end, min(len(tokens), head.end + 7)):
        if tokens[at] in words.colours:
            return [tokens[at]]
        if at in named or tokens[at] not in words.afterwords:
            break
    return []


def find_need(tokens: Sequence[str], words: Lexicon, labels_in_memory: Sequence[str]) -> str | None:
    """What answers a need said without a name; of several, the first that was seen before."""
    for said, labels in words.needs:
        if any(tuple(tokens[at : at + len(said)]) == said for at in range(len(tokens) - len(said) + 1)):
            return next((label for label in labels if label in labels_in_memory), labels[0])
    return None


def _answer(
    label: str, description: str, mentions: Sequence[Mention], request: ParseTaskRequest, notes: str
) -> ParsedTask:
    places = [one.label for one in mentions if one.context and one.label not in ("none", label)]
    candidates = [*places, label, *lexicon().near.get(label, ())]
    memory_object = next((one for one in candidates if one in request.labels_in_memory), None)
    return ParsedTask(
        yolo_class=label, memory_object=memory_object, description=description[:120], parser=PARSER, notes=notes[:500]
    )
