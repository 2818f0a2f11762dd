"""The third voter: a vision-language model that is asked whether a thing is in the picture (requirement A11)."""

from dataclasses import dataclass

from contracts.vision import ModelInfo
from inference.language.prompts import PresenceAnswer, presence_prompt
from inference.language.providers import Providers


@dataclass(frozen=True)
class PresenceJudge:
    """The port `VisionLanguageModel`, over one model; left alone while it is down, given up past the deadline."""

    providers: Providers
    deadline_s: float

    @property
    def name(self) -> str:
        return self.providers.providers[0].model.name

    def info(self) -> ModelInfo:
        return self.providers.providers[0].info("vlm")

    async def present(self, jpeg: bytes, description: str) -> bool:
        answer, _ = await self.providers.ask(
            presence_prompt(jpeg, description), PresenceAnswer, deadline_s=self.deadline_s
        )
        return answer.present == "yes"
