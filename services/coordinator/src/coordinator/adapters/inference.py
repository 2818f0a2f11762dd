"""inference over HTTP."""

from contracts.language import ReasonReply, ReasonRequest
from contracts.problem import Dependency
from contracts.vision import ParsedTask, ParseTaskRequest, ValidateRequest, Validation
from mesh.errors import UnavailableError, UpstreamError
from mesh.http import ServiceClient


class InferenceClient:
    """The port `Eyes`, for real."""

    def __init__(self, base_url: str, *, timeout_s: float, parse_timeout_s: float, reason_timeout_s: float) -> None:
        self._client = ServiceClient("inference", base_url, timeout_s=timeout_s)
        self._parse_timeout_s = parse_timeout_s
        self._reason_timeout_s = reason_timeout_s

    async def aclose(self) -> None:
        await self._client.aclose()

    async def parse_task(self, request: ParseTaskRequest) -> ParsedTask:
        return await self._client.post("/parse-task", request, ParsedTask, timeout_s=self._parse_timeout_s)

    async def validate(self, request: ValidateRequest, *, timeout_s: float) -> Validation:
        return await self._client.post("/validate", request, Validation, timeout_s=timeout_s)

    async def evidence(self, validation_id: str) -> bytes:
        return (await self._client.call("GET", f"/validations/{validation_id}.jpg")).content

    async def reason(self, request: ReasonRequest) -> ReasonReply:
        try:
            return await self._client.post("/reason", request, ReasonReply, timeout_s=self._reason_timeout_s)
        except UpstreamError as error:
            raise UnavailableError("inference", error.detail) from error

    async def dependency(self) -> Dependency:
        return await self._client.dependency()
