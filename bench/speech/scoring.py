"""Whether what was heard means what was said, by the coordinator's own reading of both."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from rapidfuzz.distance import Levenshtein

from bench.speech.playing import Clip
from contracts.intent import Intent, Understood, WantedAction
from contracts.vision import ParsedTask, ParseTaskRequest
from coordinator.commands.command_reader import CommandReader
from coordinator.commands.readings import meaning
from coordinator.settings import Settings
from inference.language.providers import Providers
from inference.parsing.task_parsing import Reader
from mesh.clock import SystemClock

STARTS = frozenset((WantedAction.FIND, WantedAction.BRING, WantedAction.GO, WantedAction.DOCK))
"""Actions on which the robot sets off."""


class Rules:
    """The parser without a language model."""

    def __init__(self) -> None:
        none = Providers.of((), retry_after_s=1.0, clock=SystemClock())
        self._reader = Reader(none, none, deadline_s=8.0)

    async def parse_task(self, request: ParseTaskRequest) -> ParsedTask:
        return await self._reader.parse(request)


class NoMemory:
    async def labels(self) -> tuple[()]:
        return ()

    async def objects(self, label: str | None, limit: int, room_id: int | None = None) -> tuple[()]:
        return ()


@dataclass(frozen=True, slots=True)
class Scored:
    clip: Clip
    errors: int
    """Words of the plain reading that are wrong, missing or too many."""
    words: int
    plain_right: bool
    """The plain reading alone means what was said."""
    right: bool
    """What is gone on with, or the first choice of the question, means what was said."""
    offered: bool
    """It is gone on with, or among the choices."""
    asked: bool
    """A person is asked back."""
    wrong: bool
    """Without asking, the robot would set off for something that was not said."""


class Scorer:
    def __init__(self) -> None:
        any_: Any = NoMemory()
        rules: Any = Rules()
        self._reader = CommandReader(settings=Settings(), inference=rules, memory=any_)
        self._known: dict[str, Intent] = {}

    async def score(self, clip: Clip) -> Scored:
        said = meaning(await self._intent(clip.command))
        plain = meaning(await self._intent(clip.plain))
        told = await self._reader.understand((clip.hot, clip.plain))
        first = told.intent or (told.choices[0].intent if told.choices else None)
        right = first is not None and meaning(first) == said
        reference, heard = _words(clip.command), _words(clip.plain)
        return Scored(
            clip=clip,
            errors=Levenshtein.distance(reference, heard),
            words=len(reference),
            plain_right=plain == said,
            right=right,
            offered=right or any(meaning(one.intent) == said for one in told.choices),
            asked=told.intent is None,
            wrong=_sets_off(told) and not right,
        )

    async def _intent(self, text: str) -> Intent:
        if text not in self._known:
            self._known[text] = await self._reader.intent(text)
        return self._known[text]


def _sets_off(told: Understood) -> bool:
    return told.intent is not None and told.intent.action in STARTS and bool(_things(told.intent))


def _things(intent: Intent) -> Sequence[object]:
    return intent.targets if intent.action is not WantedAction.DOCK else (intent,)


def _words(text: str) -> list[str]:
    return re.sub(r"[^a-z' ]", " ", text.lower()).split()
