"""Opens the language models that the settings name: a reader of commands, a phraser of facts, a third voter."""

from collections.abc import Sequence
from contextlib import AsyncExitStack
from dataclasses import dataclass

from inference.language.language_settings import LanguageSettings, ModelServer, ReaderKind
from inference.language.providers import Provider, Providers
from inference.parsing.task_parsing import Reader
from inference.ports import LanguageModel, VisionLanguageModel
from inference.reasoning.reasoner import Reasoner
from inference.validation.presence import PresenceJudge
from mesh.clock import Clock

CLIENT_TIMEOUT_S = 120.0
"""Of a connection; the deadlines of the callers are shorter."""


@dataclass(frozen=True)
class Languages:
    reader: Reader
    reasoner: Reasoner
    vlm: VisionLanguageModel | None


def open_languages(
    settings: LanguageSettings,
    stack: AsyncExitStack,
    clock: Clock,
    *,
    given: Sequence[LanguageModel] | None = None,
    vlm: VisionLanguageModel | None = None,
) -> Languages:
    """`given` stands for the models before the rules; without it the settings' own, closed with `stack`."""
    rules_at = settings.language_order.index(ReaderKind.RULES)
    if given is None:
        before = _open(settings, settings.language_order[:rules_at], stack)
        after = _open(settings, settings.language_order[rules_at + 1 :], stack)
    else:
        before, after = list(given), []
    first = Providers.of(before, retry_after_s=settings.model_retry_after_s, clock=clock)
    second = Providers.of(after, retry_after_s=settings.model_retry_after_s, clock=clock)
    every = Providers(clock, (*first.providers, *second.providers))
    return Languages(
        Reader(first, second, settings.parse_deadline_s),
        Reasoner(every, settings.reason_deadline_s),
        vlm if vlm is not None else _judge(settings, stack, clock),
    )


def _open(settings: LanguageSettings, kinds: Sequence[ReaderKind], stack: AsyncExitStack) -> list[LanguageModel]:
    named = {ReaderKind.OLLAMA: settings.ollama_url, ReaderKind.OPENAI: settings.openai_url}
    backends = [ModelServer(kind.value) for kind in kinds if named.get(kind)]
    names = {ModelServer.OLLAMA: settings.ollama_model, ModelServer.OPENAI: settings.openai_model}
    return [_model(settings, backend, names[backend], stack) for backend in backends]


def _judge(settings: LanguageSettings, stack: AsyncExitStack, clock: Clock) -> PresenceJudge | None:
    url = {ModelServer.OLLAMA: settings.ollama_url, ModelServer.OPENAI: settings.openai_url}[settings.vlm_server]
    if not url or not settings.vlm_model:
        return None
    model = _model(settings, settings.vlm_server, settings.vlm_model, stack)
    providers = Providers(clock, (Provider.of(model, settings.model_retry_after_s),))
    return PresenceJudge(providers, settings.vlm_deadline_s)


def _model(settings: LanguageSettings, backend: ModelServer, model: str, stack: AsyncExitStack) -> LanguageModel:
    if backend is ModelServer.OLLAMA:
        from inference.adapters.ollama_models import OllamaModel

        opened: LanguageModel = OllamaModel(settings.ollama_url, model, timeout_s=CLIENT_TIMEOUT_S)
    else:
        from inference.adapters.openai_models import OpenAiModel

        key = settings.openai_api_key.get_secret_value()
        opened = OpenAiModel(settings.openai_url, model, timeout_s=CLIENT_TIMEOUT_S, api_key=key)
    stack.push_async_callback(opened.aclose)
    return opened
