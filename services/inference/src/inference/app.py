"""Composition root: the only module that knows which parts are real."""

from collections.abc import AsyncGenerator, Callable, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from typing import TypedDict

from fastapi import FastAPI, Request

from contracts.problem import Dependency
from inference.adapters.bridge_camera import BridgeCamera
from inference.languages import open_languages
from inference.perception.models import Loaded, Models
from inference.perception.perception import Perception
from inference.perception.worker import Worker
from inference.ports import Camera, LanguageModel, VisionLanguageModel
from inference.routes import get_inference, router
from inference.service import Inference
from inference.settings import ModelSet, Settings
from inference.validation.calibration import read_calibration
from inference.validation.validation import Validator
from mesh.app import make_app
from mesh.bus import Bus, open_bus
from mesh.clock import Clock, SystemClock
from mesh.tasks import Tasks, end_this_process

BODY_BYTES_MAX = 10_000_000
COLOUR_CROPS_MAX = {ModelSet.SIM: 12, ModelSet.COCO: 1}
"""Crops a frame whose colour is asked for: 2 ms each for the small model, over 100 ms for ViT-B/32."""


class State(TypedDict):
    inference: Inference


def create_app(
    settings: Settings,
    *,
    bus: Bus | None = None,
    camera: Camera | None = None,
    models: Callable[[], Loaded] | None = None,
    language_models: Sequence[LanguageModel] | None = None,
    vlm: VisionLanguageModel | None = None,
    clock: Clock | None = None,
    on_death: Callable[[], None] = end_this_process,
) -> FastAPI:
    """The service; whatever is not given is the real thing that `settings` name. `models` blocks while it loads."""

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncGenerator[State]:
        async with AsyncExitStack() as stack:
            real_clock = clock or SystemClock()
            real_bus = (
                bus
                if bus is not None
                else await stack.enter_async_context(open_bus(settings.redis_url, settings.own_key))
            )
            real_camera = (
                camera if camera is not None else BridgeCamera(settings.robot_bridge_url, key=settings.own_key)
            )
            stack.push_async_callback(real_camera.aclose)
            languages = open_languages(settings, stack, real_clock, given=language_models, vlm=vlm)
            worker = Worker(settings.waiting_max)
            stack.callback(worker.close)
            eyes = Models(
                load=models if models is not None else _real_loader(settings),
                worker=worker,
                colour_crops_max=(
                    COLOUR_CROPS_MAX[settings.model_set]
                    if settings.colour_crops_max is None
                    else settings.colour_crops_max
                ),
            )
            inference = Inference(
                models=eyes,
                perception=Perception(settings, real_camera, eyes, real_bus, real_clock),
                validator=Validator(
                    real_camera,
                    eyes,
                    languages.vlm,
                    settings.validate_frame_wait_s,
                    settings.vlm_deadline_s,
                    read_calibration(settings.clip_file.parent),
                ),
                reader=languages.reader,
                reasoner=languages.reasoner,
                bus=real_bus,
                clock=real_clock,
                frame_age_max_s=settings.frame_age_max_s,
            )
            tasks = await stack.enter_async_context(Tasks(on_death=on_death))
            tasks.start("quicken", inference.models.quicken(), forever=False)
            tasks.start("perception", inference.perception.run())
            tasks.start("follow-target", inference.perception.follow_target())
            yield {"inference": inference}

    async def dependencies(request: Request) -> Sequence[Dependency]:
        return (await get_inference(request)).dependencies()

    async def measure(request: Request) -> None:
        (await get_inference(request)).measure()

    app = make_app(
        "inference",
        lifespan=lifespan,
        dependencies=dependencies,
        settings=settings,
        measure=measure,
        body_bytes_max=BODY_BYTES_MAX,
        description="Sees and reads: detector, image-text model, three votes, task parsing.",
    )
    app.include_router(router)
    return app


def _real_loader(settings: Settings) -> Callable[[], Loaded]:
    from inference.adapters.loading import loader

    return loader(settings)
