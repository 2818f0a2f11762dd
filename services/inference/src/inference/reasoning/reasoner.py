"""Puts facts into words: the model phrases, and what it says beyond the facts is refused."""

import time
from dataclasses import dataclass

from contracts.language import ReasonReply, ReasonRequest
from inference.language.prompts import ReasonAnswer, reason_prompt
from inference.language.providers import Providers
from inference.reasoning.grounding import invented


@dataclass(frozen=True)
class Reasoner:
    providers: Providers
    deadline_s: float

    async def reason(self, request: ReasonRequest) -> ReasonReply:
        """Raises `NoAnswerError` (503) where no language model can answer from these facts."""

        def objection(said: ReasonAnswer) -> str:
            extra = invented(said.answer, (request.question, *request.facts))
            return f"said what no fact holds: {', '.join(extra)}" if extra else ""

        began_s = time.perf_counter()
        answer, by = await self.providers.ask(
            reason_prompt(request), ReasonAnswer, deadline_s=self.deadline_s, objection=objection
        )
        took_ms = round((time.perf_counter() - began_s) * 1000, 1)
        return ReasonReply(answer=answer.answer, by=by, took_ms=took_ms)
