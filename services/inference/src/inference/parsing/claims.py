"""What is kept of a language model's claim about a command: a label, a remembered label, words that were said. Pure."""

from contracts.colours import COLOUR_WORDS
from contracts.vision import ParsedTarget, ParseTaskRequest
from inference.language.prompts import TaskAnswer
from inference.parsing.describing import DESCRIPTION_WORDS_MAX
from inference.parsing.lexicon import lexicon
from inference.perception.classes import label_of
from vocabulary.folding import joined, plain_words_of
from vocabulary.spelling import singular_forms


def checked(answer: TaskAnswer, request: ParseTaskRequest, *, said: str, by: str) -> ParsedTarget:
    """The claim as far as it can be true: whatever a command talked a model into, no other word comes through."""
    label = label_of(answer.yolo_class) or "none"
    if label == "none":
        return ParsedTarget(said=said, yolo_class="none", parser=by)
    memory_object = answer.memory_object if answer.memory_object in request.labels_in_memory else None
    return ParsedTarget(
        said=said,
        yolo_class=label,
        memory_object=memory_object,
        description=_description(answer.description, request.command, label),
        parser=by,
    )


def _description(claimed: str, command: str, label: str) -> str:
    """At most four words, each said or a plain name of the class; the label where none of them names anything.

    A colour that was misspelt counts as said, and is told in its right spelling.
    """
    words = lexicon()
    plain = words.attributes
    said: set[str] = set()
    for token in joined(plain_words_of(command)).split():
        said.update((token, words.attribute(token), COLOUR_WORDS.get(token, token), *singular_forms(token)))
    names = {word for name in words.names.values() if name.label == label for word in name.words}
    kept = [
        word
        for word in map(words.attribute, joined(plain_words_of(claimed)).split())
        if (word in said and word not in words.fillers)
        or word in label.split()
        or (word in names and word not in plain)
    ][-DESCRIPTION_WORDS_MAX:]
    if any(word not in plain or word in label.split() for word in kept):
        return " ".join(kept)
    return " ".join([*kept[-(DESCRIPTION_WORDS_MAX - 1) :], label])
