"""Reads a command: language models and rules in the order set; the answer names who gave it."""

import asyncio
from collections.abc import Sequence
from dataclasses import dataclass

from contracts.reading import Mood
from contracts.vision import ModelInfo, ParsedTarget, ParsedTask, ParseTaskRequest
from inference.language.prompts import TaskAnswer, parse_prompt
from inference.language.providers import NoAnswerError, Providers
from inference.parsing import parser
from inference.parsing.claims import checked
from inference.parsing.splitting import PARTS_MAX, Part, split
from vocabulary.languages import is_foreign
from vocabulary.moods import read
from vocabulary.restrictions import restrictions_in

NONE = "none"
ASKING = frozenset((Mood.FIND, Mood.QUESTION, Mood.COUNT))
"""Moods in which a thing is named that somebody wants to know of."""


@dataclass(frozen=True)
class Reader:
    """The rules always answer; `before` are heard first, `after` where the rules know nothing."""

    before: Providers
    after: Providers
    deadline_s: float

    async def parse(self, request: ParseTaskRequest) -> ParsedTask:
        """Every part of what the command asks for, in order. Never fails: at worst every class is 'none'.

        No model is asked about what is denied, told, or an order: the mood is read by rules, before.
        """
        reading = read(request.command)
        if is_foreign(request.command):
            return ParsedTask(mood=Mood.UNKNOWN, notes="it seems to be in another language: English is understood")
        if reading.mood not in ASKING:
            return ParsedTask(mood=reading.mood, notes=f"that is no asking to find: {reading.mood.value}")
        command = reading.asked or request.command
        parts = split(command)
        targets = await self._read_each(parts, request.labels_in_memory)
        named = any(one.named for one in targets)
        notes = [f"left out, not asked for: {reading.about}"] if reading.about else []
        if len(split(parts[-1].meaning)) > 1:
            notes.append(f"the rest was not read: {PARTS_MAX} things at most, one command")
        return ParsedTask(
            targets=tuple(targets),
            notes="; ".join(notes)[:500],
            mood=reading.mood if reading.mood is not Mood.FIND or reading.sure or named else Mood.UNKNOWN,
            restrictions=restrictions_in(command),
        )

    async def _read_each(self, parts: Sequence[Part], memory: Sequence[str]) -> list[ParsedTarget]:
        """Each has an equal share of the time that is left."""
        loop = asyncio.get_running_loop()
        ends_s = loop.time() + self.deadline_s
        targets: list[ParsedTarget] = []
        for at, part in enumerate(parts):
            share_s = max(0.0, ends_s - loop.time()) / (len(parts) - at)
            targets.append(await self._read(part, memory, share_s))
        return targets

    def infos(self) -> list[ModelInfo]:
        rules = ModelInfo(role="parser", name=parser.PARSER, backend="rules")
        before, after = ([one.info("parser") for one in group.providers] for group in (self.before, self.after))
        return [*before, rules, *after]

    async def _read(self, part: Part, memory: Sequence[str], deadline_s: float) -> ParsedTarget:
        request = ParseTaskRequest(command=part.meaning, labels_in_memory=tuple(memory))
        claimed, trouble = await self._ask(self.before, part, request, deadline_s)
        if claimed is not None:
            return claimed
        by_rules, more_trouble = parser.parse(request, part.said), ""
        if by_rules.yolo_class == NONE and self.after.providers:
            claimed, more_trouble = await self._ask(self.after, part, request, deadline_s)
            if claimed is not None:
                return claimed.model_copy(update={"notes": trouble[:500]})
        notes = "; ".join(filter(None, (by_rules.notes, trouble, more_trouble)))
        return by_rules.model_copy(update={"notes": notes[:500]})

    async def _ask(
        self, group: Providers, part: Part, request: ParseTaskRequest, deadline_s: float
    ) -> tuple[ParsedTarget | None, str]:
        """What a model claims, or why there is nothing to take."""
        if not group.providers:
            return None, ""
        try:
            answer, by = await group.ask(parse_prompt(request), TaskAnswer, deadline_s=deadline_s)
        except NoAnswerError as error:
            return None, error.detail
        claimed = checked(answer, request, said=part.said, by=by)
        return (claimed, "") if claimed.yolo_class != NONE else (None, f"{by} saw nothing in it")
