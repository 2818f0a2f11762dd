"""memory over HTTP."""

from collections.abc import Sequence

from contracts.memory import LabelCount, LookBatch, RecallReply, RecallRequest, RememberedObject, View
from contracts.problem import Dependency
from mesh.http import ServiceClient


class MemoryClient:
    """The port `Memory`, for real."""

    def __init__(self, base_url: str, *, timeout_s: float) -> None:
        self._client = ServiceClient("memory", base_url, timeout_s=timeout_s)

    async def aclose(self) -> None:
        await self._client.aclose()

    async def labels(self) -> Sequence[LabelCount]:
        return await self._client.get_list("/labels", LabelCount)

    async def recall(self, request: RecallRequest) -> RecallReply:
        return await self._client.post("/recall", request, RecallReply)

    async def looks(self, batch: LookBatch) -> None:
        await self._client.call("POST", "/looks", body=batch)

    async def views(self, label: str, limit: int) -> Sequence[View]:
        return await self._client.get_list("/views", View, label=label, limit=limit)

    async def objects(self, label: str | None, limit: int) -> Sequence[RememberedObject]:
        wanted = {"label": label} if label is not None else {}
        return await self._client.get_list("/objects", RememberedObject, limit=limit, **wanted)

    async def dependency(self) -> Dependency:
        return await self._client.dependency()
