"""Reads a command by rules: which COCO class is meant, where to look first, and in which words. Pure; never raises.

Every name in the command is found (longest first, plurals and slips of the finger included). Names behind a word of
place ("on the table") or a negation ("not the cup") are context. Of the others the first that is asked for is wanted;
of names side by side the last is the head ("coffee *table*"). The description is made of the head and the attributes
said with it: no word is added that nobody said.
"""

from collections.abc import Sequence

from contracts.vision import ParsedTarget, ParseTaskRequest
from inference.parsing.describing import DESCRIPTION_WORDS_MAX, colour_of_the_other, description_of
from inference.parsing.lexicon import Lexicon, lexicon
from inference.parsing.mentions import Mention, Role, find_mentions, groups_of, is_asked, with_roles
from inference.parsing.needs import find_need
from vocabulary.folding import Word, plain_words_of

PARSER = "rules"
NONE = "none"


def parse(request: ParseTaskRequest, said: str = "") -> ParsedTarget:
    """What the command means, as far as the rules can tell; `yolo_class` is 'none' when nothing known is named.

    `said` are the words of the person, where they are not the command.
    """
    said = said or request.command
    words = lexicon()
    tokens = plain_words_of(request.command)
    mentions = with_roles(tokens, _believable(tokens, find_mentions(tokens, words), words), words)
    group, description = _wanted(tokens, mentions, words)
    head = group[-1] if group else None
    needed = find_need(tokens, words.activities, request.labels_in_memory)
    if needed is None and (head is None or head.label == NONE):
        needed = find_need(tokens, words.needs, request.labels_in_memory)
    if needed is not None:
        return _answer(said, needed, needed, mentions, request, f"the need for a {needed} was read from the wording")
    if head is None or head.label == NONE:
        notes = f"the detector knows no '{head.said}'" if head is not None else "names nothing the detector knows"
        return ParsedTarget(said=said, yolo_class=NONE, named=head is not None, parser=PARSER, notes=notes)
    literal = " ".join(token.text for token in tokens[head.start : head.end])
    notes = f"'{literal}' was read as '{head.said}'" if head.corrected else ""
    return _answer(said, head.label, description, mentions, request, notes)


def _believable(tokens: Sequence[Word], mentions: Sequence[Mention], words: Lexicon) -> list[Mention]:
    """A word is taken for a slip only among words that are known: Turkish 'bul' is no misspelt bull."""
    named = {at for one in mentions if one.corrected for at in range(one.start, one.end)}
    known = any(
        words.is_plain(token.text) or words.is_attribute(token.text) or token.text in words.vocabulary
        for at, token in enumerate(tokens)
        if at not in named
    )
    return [one for one in mentions if known or not one.corrected or len(named) == len(tokens)]


def _wanted(tokens: Sequence[Word], mentions: Sequence[Mention], words: Lexicon) -> tuple[list[Mention], str]:
    """The names of the thing wanted and its description; nothing when only context is known."""
    groups = groups_of(tokens, mentions)
    things = [group for group in groups if group[-1].label != "person"] or groups
    asked = [group for group in things if is_asked(tokens, group[0], words)] or things
    other = colour_of_the_other(tokens, mentions, words)
    if asked:
        group = asked[0]
        described = description_of(tokens, group, mentions, words)
        if other is not None and other[0] is group[-1]:
            described = _together(other[1], described)
        return group, described
    if other is not None and other[0].role is Role.NEGATED:
        return [other[0]], " ".join([*other[1], other[0].said])
    placed = [one for one in mentions if one.role is Role.CONTEXT]
    if not placed or _asks_for_unknown(tokens, mentions, words):
        return [], ""
    return [placed[0]], description_of(tokens, [placed[0]], mentions, words)


def _together(attributes: Sequence[str], described: str) -> str:
    """'a wooden bowl, a small one': both, as far as four words go and no second colour is said."""
    said = described.split()
    colours = lexicon().colours
    more = [word for word in attributes if word not in said and not (word in colours and colours.intersection(said))]
    return " ".join([*more, *said]) if len(more) + len(said) <= DESCRIPTION_WORDS_MAX else described


def _asks_for_unknown(tokens: Sequence[Word], mentions: Sequence[Mention], words: Lexicon) -> bool:
    named = {at for one in mentions for at in range(one.start, one.end)}
    return any(
        at not in named and not words.is_plain(token.text) and not words.is_attribute(token.text)
        for at, token in enumerate(tokens)
    )


def _answer(
    said: str, label: str, description: str, mentions: Sequence[Mention], request: ParseTaskRequest, notes: str
) -> ParsedTarget:
    places = [one.label for one in mentions if one.role is Role.CONTEXT and one.label not in (NONE, label)]
    candidates = [*places, label, *lexicon().near.get(label, ())]
    memory_object = next((one for one in candidates if one in request.labels_in_memory), None)
    return ParsedTarget(
        said=said,
        yolo_class=label,
        memory_object=memory_object,
        description=description[:120],
        parser=PARSER,
        notes=notes[:500],
    )
