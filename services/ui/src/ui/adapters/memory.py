"""memory over HTTP: what is remembered, forgetting, and carrying it elsewhere."""

from collections.abc import Sequence
from urllib.parse import quote

from contracts.memory import DeletedReply, ImportReply, LabelCount, RememberedObject, View
from contracts.problem import Dependency
from mesh.http import ServiceClient

OBJECTS_MAX = 500
VIEWS_MAX = 1000


class MemoryClient:
    """The port `Memory`, for real."""

    def __init__(self, base_url: str, *, timeout_s: float, transfer_timeout_s: float) -> None:
        self._client = ServiceClient("memory", base_url, timeout_s=timeout_s)
        self._transfer_timeout_s = transfer_timeout_s

    async def aclose(self) -> None:
        await self._client.aclose()

    async def labels(self) -> Sequence[LabelCount]:
        return await self._client.get_list("/labels", LabelCount)

    async def objects(self) -> Sequence[RememberedObject]:
        return await self._client.get_list("/objects", RememberedObject, limit=OBJECTS_MAX)

    async def views(self) -> Sequence[View]:
        return await self._client.get_list("/views", View, limit=VIEWS_MAX)

    async def forget_object(self, object_id: int) -> int:
        return (await self._client.delete(f"/objects/{object_id}", DeletedReply)).deleted

    async def forget_label(self, label: str) -> int:
        return (await self._client.delete(f"/labels/{quote(label, safe='')}", DeletedReply)).deleted

    async def export(self) -> bytes:
        return (await self._client.call("GET", "/export", timeout_s=self._transfer_timeout_s)).content

    async def import_(self, data: bytes) -> ImportReply:
        return await self._client.post("/import", data, ImportReply, timeout_s=self._transfer_timeout_s)

    async def dependency(self) -> Dependency:
        return await self._client.dependency()
