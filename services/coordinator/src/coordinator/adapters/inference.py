"""inference over HTTP."""

import httpx

from contracts.language import ReasonReply, ReasonRequest
from contracts.vision import ParsedTask, ParseTaskRequest, ValidateRequest, Validation
from coordinator.settings import Settings
from mesh.errors import UnavailableError, UpstreamError
from mesh.http import ServiceClient, path_of


class InferenceClient(ServiceClient):
    """The port `Inference`, for real."""

    def __init__(self, settings: Settings, *, transport: httpx.AsyncBaseTransport | None = None) -> None:
        super().__init__(
            "inference",
            settings.inference_url,
            key=settings.own_key,
            timeout_s=settings.call_timeout_s,
            transport=transport,
        )
        self._parse_timeout_s = settings.parse_timeout_s
        self._reason_timeout_s = settings.reason_timeout_s

    async def parse_task(self, request: ParseTaskRequest) -> ParsedTask:
        return await self.post("/parse-task", request, ParsedTask, timeout_s=self._parse_timeout_s)

    async def validate(self, request: ValidateRequest, *, timeout_s: float) -> Validation:
        return await self.post("/validate", request, Validation, timeout_s=timeout_s)

    async def evidence(self, validation_id: str) -> bytes:
        return (await self.call("GET", path_of("validations", f"{validation_id}.jpg"))).content

    async def reason(self, request: ReasonRequest) -> ReasonReply:
        try:
            return await self.post("/reason", request, ReasonReply, timeout_s=self._reason_timeout_s)
        except UpstreamError as error:
            raise UnavailableError("inference", error.detail) from error
