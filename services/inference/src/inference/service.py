"""What the routes work with: the parts of the service, and the two errands that need several of them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from prometheus_client import Gauge

from contracts.geometry import Pose2D
from contracts.problem import Dependency, DependencyState
from contracts.vision import Detections, ModelInfo, ModelState
from inference.parsing.task_parsing import Reader
from inference.perception.images import decode
from inference.perception.models import Models
from inference.perception.perception import Perception
from inference.ports import RgbImage
from inference.reasoning.reasoner import Reasoner
from inference.validation.validation import Validator
from mesh.bus import Bus, redis_dependency
from mesh.clock import Clock

FRAME_AGE = Gauge("inference_frame_age_seconds", "since a frame was last looked at; NaN = never")
WAITING = Gauge("inference_calls_waiting", "calls that wait for the models, or run")


@dataclass(frozen=True)
class Inference:
    models: Models
    perception: Perception
    validator: Validator
    reader: Reader
    reasoner: Reasoner
    bus: Bus
    clock: Clock
    frame_age_max_s: float

    def measure(self) -> None:
        """What Prometheus is told at a scrape."""
        age_s = self.perception.frame_age_s()
        FRAME_AGE.set(math.nan if age_s is None else age_s)
        WAITING.set(self.models.worker.waiting)

    async def detect(self, encoded: bytes, *, stamp_s: float | None = None, pose: Pose2D | None = None) -> Detections:
        sight = await self.models.see(encoded)
        return Detections(
            stamp_s=self.clock.now_s() if stamp_s is None else stamp_s,
            image_width_px=sight.image.shape[1],
            image_height_px=sight.image.shape[0],
            pose=pose,
            detections=sight.look.detections,
            model=sight.look.model,
            took_ms=sight.look.took_ms,
        )

    async def detect_newest(self) -> Detections:
        frame = await self.validator.fresh_frame(None)
        return await self.detect(frame.jpeg, stamp_s=frame.stamp_s, pose=frame.pose)

    async def newest_image(self) -> RgbImage:
        return decode((await self.validator.fresh_frame(None)).jpeg)

    def model_infos(self) -> list[ModelInfo]:
        vlm = self.validator.vlm
        third = (
            ModelInfo(role="vlm", name="", backend="", state=ModelState.NOT_CONFIGURED, detail="its vote abstains")
            if vlm is None
            else vlm.info()
        )
        return [*self.models.infos(), third, *self.reader.infos()]

    def helpers(self) -> list[ModelInfo]:
        """The models that are asked in words; those of a role that is not filled are left out."""
        vlm = self.validator.vlm
        return [*([vlm.info()] if vlm is not None else []), *self.reader.infos()]

    def dependencies(self) -> Sequence[Dependency]:
        """Ready means: models loaded, frames looked at within the last seconds, and Redis there.

        A helper that does not help is a warning: the rules read, and two votes decide, without it.
        """
        age_s = self.perception.frame_age_s()
        flowing = age_s is not None and age_s <= self.frame_age_max_s
        told = "no frame yet" if age_s is None else f"last frame {age_s:.1f} s ago"
        why = f"; {self.perception.trouble}" if self.perception.trouble and not flowing else ""
        return [
            _models(self.models),
            Dependency.of("frames", ok=flowing, detail=told + why),
            redis_dependency(self.bus),
            *(
                Dependency(name=one.name, state=DependencyState.WARNING, detail=one.detail)
                for one in self.helpers()
                if one.state in {ModelState.AWAY, ModelState.ANSWERS_WRONG}
            ),
        ]


def _models(models: Models) -> Dependency:
    if models.problem or not models.trouble:
        return Dependency.of("models", ok=not models.problem, detail=models.problem)
    return Dependency(name="models", state=DependencyState.WARNING, detail=models.trouble)
