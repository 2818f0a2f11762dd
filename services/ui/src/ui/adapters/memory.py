"""memory over HTTP; for now the page only tells whether it is there."""

from contracts.problem import Dependency
from mesh.http import ServiceClient


class MemoryService:
    """The port `Memory`, for real."""

    def __init__(self, base_url: str, *, timeout_s: float) -> None:
        self._client = ServiceClient("memory", base_url, timeout_s=timeout_s)

    async def aclose(self) -> None:
        await self._client.aclose()

    async def dependency(self) -> Dependency:
        return await self._client.dependency()
