"""Reads a command: the language model first where there is one, the rules behind it; the answer names who gave it."""

import asyncio
from dataclasses import dataclass

import structlog

from contracts.vision import ModelInfo, ParsedTask, ParseTaskRequest
from inference import parser
from inference.breaker import Breaker
from inference.ports import LanguageModel
from mesh.clock import Clock
from mesh.errors import UnavailableError, UpstreamError

log = structlog.get_logger()


@dataclass
class Reader:
    language_model: LanguageModel | None
    breaker: Breaker
    deadline_s: float
    clock: Clock

    async def parse(self, request: ParseTaskRequest) -> ParsedTask:
        by_rules = parser.parse(request)
        if self.language_model is None:
            return by_rules
        if not self.breaker.allows(self.clock.now_s()):
            return _with_note(by_rules, f"{self.language_model.name} is left alone: {self.breaker.last_error}")
        try:
            async with asyncio.timeout(self.deadline_s):
                claimed = await self.language_model.parse(request)
        except TimeoutError:
            return self._gave_up(self.language_model, by_rules, f"no answer within {self.deadline_s:g} s")
        except (UnavailableError, UpstreamError) as error:
            return self._gave_up(self.language_model, by_rules, error.detail)
        self.breaker.succeeded()
        if claimed.yolo_class == "none" and by_rules.yolo_class != "none":
            return _with_note(by_rules, f"{claimed.parser} saw nothing in it")
        return claimed

    def infos(self) -> list[ModelInfo]:
        rules = ModelInfo(role="parser", name=parser.PARSER, backend="rules")
        if self.language_model is None:
            return [rules]
        down = self.breaker.last_error
        name = self.language_model.name
        return [ModelInfo(role="parser", name=name, backend="ollama", available=not down, detail=down), rules]

    def _gave_up(self, model: LanguageModel, by_rules: ParsedTask, why: str) -> ParsedTask:
        log.warning("the language model did not answer; the rules did", model=model.name, reason=why)
        self.breaker.failed(self.clock.now_s(), why)
        return _with_note(by_rules, f"{model.name}: {why}")


def _with_note(task: ParsedTask, note: str) -> ParsedTask:
    return task.model_copy(update={"notes": "; ".join(part for part in (task.notes, note) if part)[:500]})
