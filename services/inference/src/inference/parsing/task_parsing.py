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
from vocabulary.moods import Reading, read
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
            return _nothing(Mood.UNKNOWN, "it seems to be in another language: English is understood")
        if reading.mood not in ASKING:
            return _nothing(reading.mood, f"that is no asking to find: {reading.mood.value}")
        asked = await self._read_parts(request.model_copy(update={"command": reading.asked or request.command}))
        return asked.model_copy(
            update={
                "mood": _mood(reading, asked),
                "restrictions": restrictions_in(reading.asked or request.command),
                "notes": "; ".join(part for part in (asked.notes, _left_out(reading)) if part)[:500],
            }
        )

    async def _read_parts(self, request: ParseTaskRequest) -> ParsedTask:
        loop = asyncio.get_running_loop()
        ends_s = loop.time() + self.deadline_s
        parts = split(request.command)
        targets: list[ParsedTarget] = []
        notes: list[str] = []
        moods: set[Mood] = set()
        for at, part in enumerate(parts):
            share_s = max(0.0, ends_s - loop.time()) / (len(parts) - at)
            target, note, mood = await self._read(part, request.labels_in_memory, share_s)
            targets.append(target)
            moods.add(mood)
            notes += [note] if note else []
        if len(split(parts[-1].meaning)) > 1:
            notes.append(f"the rest was not read: {PARTS_MAX} things at most, one command")
        first = next((one for one in targets if one.yolo_class != NONE), targets[0])
        return ParsedTask(
            yolo_class=first.yolo_class,
            memory_object=first.memory_object,
            description=first.description,
            parser=first.parser,
            notes="; ".join(dict.fromkeys(notes))[:500],
            targets=tuple(targets),
            mood=Mood.FIND if Mood.FIND in moods else Mood.UNKNOWN,
        )

    def infos(self) -> list[ModelInfo]:
        rules = ModelInfo(role="parser", name=parser.PARSER, backend="rules")
        before, after = ([one.info("parser") for one in group.providers] for group in (self.before, self.after))
        return [*before, rules, *after]

    async def _read(self, part: Part, memory: Sequence[str], deadline_s: float) -> tuple[ParsedTarget, str, Mood]:
        request = ParseTaskRequest(command=part.meaning, labels_in_memory=tuple(memory))
        claimed, trouble = await self._ask(self.before, part, request, deadline_s)
        if claimed is not None and claimed.yolo_class != NONE:
            return claimed, "", Mood.FIND
        by_rules = parser.parse(request)
        if by_rules.yolo_class != NONE or not self.after.providers:
            told = "; ".join(note for note in (by_rules.notes, trouble) if note)
            return _target(part, by_rules), told, by_rules.mood
        second, more_trouble = await self._ask(self.after, part, request, deadline_s)
        if second is not None and second.yolo_class != NONE:
            return second, trouble, Mood.FIND
        notes = "; ".join(note for note in (by_rules.notes, trouble, more_trouble) if note)
        return _target(part, by_rules), notes, by_rules.mood

    async def _ask(
        self, group: Providers, part: Part, request: ParseTaskRequest, deadline_s: float
    ) -> tuple[ParsedTarget | None, str]:
        """What a model claims, and why it is not to be taken where it is not."""
        if not group.providers:
            return None, ""
        try:
            answer, by = await group.ask(parse_prompt(request), TaskAnswer, deadline_s=deadline_s)
        except NoAnswerError as error:
            return None, error.detail
        claimed = checked(answer, request, said=part.said, by=by)
        return claimed, f"{by} saw nothing in it" if claimed.yolo_class == NONE else ""


def _nothing(mood: Mood, notes: str) -> ParsedTask:
    return ParsedTask(yolo_class=NONE, parser=parser.PARSER, notes=notes, mood=mood)


def _mood(reading: Reading, asked: ParsedTask) -> Mood:
    """A saying that asks for nothing by its verb, and names nothing, is none of ours."""
    return reading.mood if reading.mood is not Mood.FIND or reading.sure else asked.mood


def _left_out(reading: Reading) -> str:
    return f"left out, not asked for: {reading.about}" if reading.about else ""


def _target(part: Part, task: ParsedTask) -> ParsedTarget:
    return ParsedTarget(
        said=part.said,
        yolo_class=task.yolo_class,
        memory_object=task.memory_object,
        description=task.description,
        parser=task.parser,
    )
