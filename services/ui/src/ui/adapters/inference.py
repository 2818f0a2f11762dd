"""inference over HTTP: is it there? What it sees comes over the bus."""

from contracts.problem import Dependency
from mesh.http import ServiceClient


class InferenceEyes:
    """The port `Eyes`, for real."""

    def __init__(self, base_url: str, *, timeout_s: float) -> None:
        self._client = ServiceClient("inference", base_url, timeout_s=timeout_s)

    async def aclose(self) -> None:
        await self._client.aclose()

    async def dependency(self) -> Dependency:
        return await self._client.dependency()
