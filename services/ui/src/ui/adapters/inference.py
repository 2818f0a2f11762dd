"""inference over HTTP: the annotated picture, by long poll."""

import math
from typing import Final

from contracts.problem import Dependency
from mesh.errors import UpstreamError
from mesh.http import ServiceClient
from ui.ports import Frame

MARGIN_S: Final = 2.0
NO_CONTENT: Final = 204


class InferenceEyes:
    """The port `Eyes`, for real."""

    def __init__(self, base_url: str, *, timeout_s: float) -> None:
        self._client = ServiceClient("inference", base_url, timeout_s=timeout_s)

    async def aclose(self) -> None:
        await self._client.aclose()

    async def annotated(self, *, after_s: float | None, wait_s: float) -> Frame | None:
        query = {"wait_s": wait_s} | ({"after": after_s} if after_s is not None else {})
        response = await self._client.call("GET", "/annotated", params=query, timeout_s=wait_s + MARGIN_S)
        if response.status_code == NO_CONTENT:
            return None
        try:
            stamp_s = float(response.headers.get("X-Stamp-S", ""))
        except ValueError as error:
            raise UpstreamError("inference", response.status_code, "the picture carries no stamp") from error
        if not math.isfinite(stamp_s):
            raise UpstreamError("inference", response.status_code, "the picture's stamp is not a number")
        return Frame(stamp_s, response.content)

    async def dependency(self) -> Dependency:
        return await self._client.dependency()
