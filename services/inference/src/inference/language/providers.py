"""Language models in order of preference: each asked for an answer of one shape, skipped while it is down."""

import asyncio
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

import structlog

from contracts.vision import ModelInfo, ModelState
from inference.language.answers import WrongAnswerError, read
from inference.language.breaker import Breaker
from inference.language.prompts import Answer
from inference.ports import LanguageModel, Prompt
from mesh.clock import Clock
from mesh.errors import UnavailableError, UpstreamError

log = structlog.get_logger()

ATTEMPTS = 2
"""An answer outside the schema is asked for once more, then the next model is."""
RETRY_TEMPERATURE = 0.4
"""At 0 the same model would say the same again."""

A = TypeVar("A", bound=Answer)


class NoAnswerError(UnavailableError):
    """No language model answered; `detail` says what each one did."""

    def __init__(self, detail: str) -> None:
        super().__init__("language model", detail)


@dataclass(frozen=True)
class Provider:
    model: LanguageModel
    breaker: Breaker

    @classmethod
    def of(cls, model: LanguageModel, retry_after_s: float) -> "Provider":
        return cls(model, Breaker(retry_after_s))

    def info(self, role: str) -> ModelInfo:
        state, why = self.breaker.state, ""
        if state is ModelState.ANSWERS_WRONG:
            why = (
                f"answers, but {'no longer' if self.breaker.was_right else 'never'} as asked: {self.breaker.last_error}"
            )
        elif state is ModelState.AWAY:
            why = self.breaker.last_error
        return ModelInfo(role=role, name=self.model.name, backend=self.model.backend, state=state, detail=why)


@dataclass(frozen=True)
class Providers:
    """The order is the preference; with none, every question ends in `NoAnswerError`."""

    clock: Clock
    providers: Sequence[Provider] = field(default=())

    @classmethod
    def of(cls, models: Sequence[LanguageModel], *, retry_after_s: float, clock: Clock) -> "Providers":
        return cls(clock, tuple(Provider.of(model, retry_after_s) for model in models))

    async def ask(
        self, prompt: Prompt, kind: type[A], *, deadline_s: float, objection: Callable[[A], str] = lambda _: ""
    ) -> tuple[A, str]:
        """The first usable answer and the name of the model that gave it.

        Each model gets an even share of what is left of `deadline_s`. `objection` says what is wrong with an answer of
        the right shape; empty when nothing is. Raises `NoAnswerError`.
        """
        ends_s = self.clock.now_s() + deadline_s
        trouble: list[str] = []
        for at, provider in enumerate(self.providers):
            name, breaker = provider.model.name, provider.breaker
            if not breaker.allows(self.clock.now_s()):
                trouble.append(f"{name} is left alone: {breaker.last_error}")
                continue
            share_s = max(0.0, ends_s - self.clock.now_s()) / (len(self.providers) - at)
            try:
                async with asyncio.timeout(share_s):
                    answer = await _attempts(provider.model, prompt, kind, objection)
            except TimeoutError:
                why = f"no answer within {share_s:.3g} s"
                breaker.failed(self.clock.now_s(), why)
            except (UnavailableError, UpstreamError) as error:
                why = error.detail
                breaker.failed(self.clock.now_s(), why)
            except WrongAnswerError as error:
                why = str(error)
                breaker.answered_wrong(self.clock.now_s(), why)
            else:
                breaker.succeeded()
                return answer, name
            log.warning("a language model gave no answer", model=name, reason=why)
            trouble.append(f"{name}: {why}")
        raise NoAnswerError("; ".join(trouble) or "none is configured")


async def _attempts(model: LanguageModel, prompt: Prompt, kind: type[A], objection: Callable[[A], str]) -> A:
    wrong = ""
    for attempt in range(ATTEMPTS):
        said = await model.complete(prompt if attempt == 0 else replace(prompt, temperature=RETRY_TEMPERATURE))
        try:
            answer = read(said, kind)
        except WrongAnswerError as error:
            wrong = str(error)
            continue
        wrong = objection(answer)
        if not wrong:
            return answer
    raise WrongAnswerError(wrong)
