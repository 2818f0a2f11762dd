"""The HTTP face: thin; every decision is made behind it."""

from collections.abc import AsyncGenerator
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Path, Query, Request
from fastapi.responses import Response, StreamingResponse

from contracts.language import ReasonReply, ReasonRequest
from contracts.vision import (
    Detections,
    EmbedReply,
    EmbedRequest,
    ModelInfo,
    ParsedTask,
    ParseTaskRequest,
    ScoreReply,
    ScoreRequest,
    ValidateRequest,
    Validation,
)
from inference.perception.annotate import AnnotatedFrame
from inference.service import Inference
from inference.validation.validation import require_box
from mesh.access import Role, requires_role
from mesh.errors import TooManyError
from mesh.latest_value import Reading
from mesh.tracing import TracedRoute

router = APIRouter(route_class=TracedRoute)

BOUNDARY = "frame"
STREAM_WAIT_S = 5.0
IMAGE_BODY: dict[str, Any] = {
    "requestBody": {
        "required": False,
        "description": "a JPEG or PNG of at most 10 MB; without one, the newest camera frame is looked at",
        "content": {kind: {"schema": {"type": "string", "format": "binary"}} for kind in ("image/jpeg", "image/png")},
    }
}
JPEG_RESPONSE: dict[int | str, dict[str, Any]] = {
    200: {"description": "the newest annotated frame, its stamp in X-Stamp-S", "content": {"image/jpeg": {}}},
    204: {"description": "nothing newer came within wait_s"},
}


async def get_inference(request: Request) -> Inference:
    """Async, because FastAPI sends a plain function to another thread and back, on every call."""
    return request.state.inference


InferenceDep = Annotated[Inference, Depends(get_inference)]


@router.post("/detect", tags=["vision"], openapi_extra=IMAGE_BODY, response_model=Detections)
@requires_role(Role.SERVICE)
async def detect(request: Request, inference: InferenceDep) -> Response:
    """Every object of a known class in the image sent, or in the newest frame."""
    body = await request.body()
    inference.models.detector()
    found = await (inference.detect(body) if body else inference.detect_newest())
    return Response(found.model_dump_json(), media_type="application/json")


@router.post("/clip-score", tags=["vision"])
@requires_role(Role.SERVICE)
async def clip_score(body: ScoreRequest, inference: InferenceDep) -> ScoreReply:
    """How well each text goes with the newest frame, and with the box in it where one is named (cosines)."""
    clip = inference.models.clip()
    if body.bbox_xyxy is not None:
        require_box(body.bbox_xyxy)
    image = await inference.newest_image()
    seen = await inference.models.score(image, body.bbox_xyxy, body.texts)
    return ScoreReply(
        scores=seen.scores,
        frame_scores=seen.frame_scores,
        threshold=clip.threshold,
        model=clip.name,
        took_ms=seen.took_ms,
    )


@router.post("/embed", tags=["vision"])
@requires_role(Role.SERVICE)
async def embed(body: EmbedRequest, inference: InferenceDep) -> EmbedReply:
    """Embeddings of texts, and of the newest frame or a box in it where asked for."""
    clip = inference.models.clip()
    if body.bbox_xyxy is not None:
        require_box(body.bbox_xyxy)
    image = await inference.newest_image() if body.image else None
    seen, said = await inference.models.embed(image, body.bbox_xyxy, body.texts)
    return EmbedReply(
        model=clip.name, image=None if seen is None else tuple(seen), texts=tuple(tuple(one) for one in said)
    )


@router.post("/validate", tags=["vision"])
@requires_role(Role.SERVICE)
async def validate(body: ValidateRequest, inference: InferenceDep) -> Validation:
    """Three votes: is this the thing? Two must agree."""
    return await inference.validator.validate(body)


@router.get(
    "/validations/{validation_id}.jpg",
    tags=["vision"],
    response_class=Response,
    responses={200: {"content": {"image/jpeg": {}}}},
)
@requires_role(Role.VIEWER)
async def evidence(
    validation_id: Annotated[str, Path(min_length=1, max_length=64)], inference: InferenceDep
) -> Response:
    """The very crop that was judged (JPEG); the newest 64 are kept, 404 for others."""
    return Response(inference.validator.evidence.jpeg(validation_id), media_type="image/jpeg")


@router.post("/parse-task", tags=["language"])
@requires_role(Role.SERVICE)
async def parse_task(body: ParseTaskRequest, inference: InferenceDep) -> ParsedTask:
    """What each part of a command claims to mean; `parser` says who read it."""
    return await inference.reader.parse(body)


@router.post("/reason", tags=["language"])
@requires_role(Role.SERVICE)
async def reason(body: ReasonRequest, inference: InferenceDep) -> ReasonReply:
    """The facts put into words that answer the question; 503 where no language model can."""
    return await inference.reasoner.reason(body)


@router.get("/models", tags=["operations"])
@requires_role(Role.VIEWER)
async def models(inference: InferenceDep) -> list[ModelInfo]:
    return inference.model_infos()


@router.get("/annotated", tags=["vision"], responses=JPEG_RESPONSE, response_class=Response)
@requires_role(Role.VIEWER)
async def annotated(
    inference: InferenceDep,
    after: Annotated[float | None, Query(description="stamp of the frame already seen", allow_inf_nan=False)] = None,
    wait_s: Annotated[float, Query(ge=0.0, le=20.0)] = 2.0,
) -> Response:
    """Long-poll: the newest frame with boxes, once it is another than the one taken at `after`."""
    found = await inference.perception.annotated.wait_for(lambda one: one.received_s != after, wait_s)
    if found is None:
        return Response(status_code=204)
    return Response(await found.value.jpeg(), media_type="image/jpeg", headers={"X-Stamp-S": f"{found.received_s:.6f}"})


@router.get("/annotated/stream", tags=["vision"], include_in_schema=False)
@requires_role(Role.VIEWER)
async def annotated_stream(inference: InferenceDep) -> StreamingResponse:
    """MJPEG, for an <img> tag or `ffplay`; ends when the reader leaves."""

    perception = inference.perception
    if perception.viewers >= perception.settings.stream_viewers_max:
        raise TooManyError(f"{perception.viewers} viewers are watching")

    async def parts() -> AsyncGenerator[bytes]:
        stamp_s: float | None = None

        def another(one: Reading[AnnotatedFrame]) -> bool:
            return one.received_s != stamp_s

        perception.viewers += 1
        try:
            while True:
                found = await perception.annotated.wait_for(another, STREAM_WAIT_S)
                if found is None:
                    continue
                stamp_s, jpeg = found.received_s, await found.value.jpeg()
                head = f"--{BOUNDARY}\r\nContent-Type: image/jpeg\r\nContent-Length: {len(jpeg)}\r\n\r\n"
                yield head.encode() + jpeg + b"\r\n"
        finally:
            perception.viewers -= 1

    return StreamingResponse(parts(), media_type=f"multipart/x-mixed-replace; boundary={BOUNDARY}")
