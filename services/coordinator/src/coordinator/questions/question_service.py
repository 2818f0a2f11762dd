"""Answers from memory, the missions and the robot (`POST /ask`). A language model may put the facts into words; it adds
none, and nothing it says is acted on: this module holds no way to move the robot.
"""

import asyncio
from functools import partial

import structlog

from contracts.asking import About, Answer
from contracts.language import ReasonRequest
from contracts.reading import Mood
from coordinator.commands.orders import ASKS_FOR_NOTHING
from coordinator.execution.mission_runner import MissionRunner
from coordinator.ports import Inference, Memory, MissionLog
from coordinator.questions.facts import QuestionFacts
from coordinator.questions.parsed_question import needs_rooms, parse_question
from coordinator.questions.rooms_meant import KnownRooms
from coordinator.settings import Settings
from mesh.clock import Clock
from mesh.errors import MeshError
from vocabulary.moods import read

log = structlog.get_logger()

NO_QUESTION = frozenset((Mood.DENIED, Mood.STATEMENT, Mood.THANKS, Mood.CONDITION, Mood.LATER))
FACT_CHARACTERS = 300
ROOMS_S_MAX = 1.0
"""An answer without the names of rooms is better than a late one."""


class QuestionService:
    def __init__(
        self,
        *,
        settings: Settings,
        memory: Memory,
        inference: Inference,
        log_: MissionLog,
        runner: MissionRunner,
        clock: Clock,
    ) -> None:
        self._settings = settings
        self._memory = memory
        self._inference = inference
        self._facts_among = partial(
            QuestionFacts, settings=settings, memory=memory, log_=log_, runner=runner, clock=clock
        )

    async def ask(self, question: str) -> Answer:
        mood = read(question).mood
        if mood in NO_QUESTION:
            return Answer(answer=f"{ASKS_FOR_NOTHING[mood]}.", about=About.UNKNOWN, phrased_by="template")
        asked, notes = parse_question(question), ""
        try:
            async with asyncio.timeout(self._settings.call_timeout_s):
                rooms = await self._known_rooms() if needs_rooms(question, asked) else KnownRooms()
                asked = parse_question(question, rooms.names)
                records, lead = await self._facts_among(rooms).of(asked)
        except (MeshError, TimeoutError) as error:
            log.warning("a question could not be answered", error=str(error))
            records, lead = (), "I cannot say: what I would have to ask is away."
            notes = str(error)[:500] or "it took too long"
        text = lead if not records else f"{lead} {' '.join(f'{record.text}.' for record in records)}"
        answer = Answer(answer=text[:2000], about=asked.about, label=asked.label, records=tuple(records),
                        phrased_by="template", notes=notes)  # fmt: skip
        plain = asked.about in {About.COUNT, About.CHANGES}  # numbers of our own, which a model may not turn
        return await self._phrased(question, answer) if records and not plain else answer

    async def _phrased(self, question: str, answer: Answer) -> Answer:
        """The same facts in a model's words, where one is there and keeps to them: inference holds it to them."""
        facts = tuple(record.text[:FACT_CHARACTERS] for record in answer.records)
        try:
            async with asyncio.timeout(self._settings.reason_timeout_s):
                reply = await self._inference.reason(ReasonRequest(question=question[:500], facts=facts))
        except (MeshError, TimeoutError) as error:
            log.debug("the template answers", reason=str(error))
            return answer
        return answer.model_copy(update={"answer": reply.answer, "phrased_by": reply.by})

    async def _known_rooms(self) -> KnownRooms:
        """None from a memory that names none within `ROOMS_S_MAX`: then a room is what lies near the things that mark
        it."""
        try:
            async with asyncio.timeout(ROOMS_S_MAX):
                return KnownRooms((await self._memory.rooms()).rooms)
        except (MeshError, TimeoutError) as error:
            log.debug("memory names no rooms", reason=str(error))
            return KnownRooms()
