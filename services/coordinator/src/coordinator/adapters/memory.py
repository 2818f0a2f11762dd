"""memory over HTTP."""

from collections.abc import Sequence

import httpx

from contracts.memory import LabelCount, LookBatch, RecallReply, RecallRequest, RememberedObject, View
from contracts.rooms import RoomGrid, RoomsReply
from coordinator.settings import Settings
from mesh.http import ServiceClient


class MemoryClient(ServiceClient):
    """The port `Memory`, for real."""

    def __init__(self, settings: Settings, *, transport: httpx.AsyncBaseTransport | None = None) -> None:
        super().__init__(
            "memory",
            settings.memory_url,
            key=settings.own_key,
            timeout_s=settings.recall_timeout_s,
            transport=transport,
        )

    async def labels(self) -> Sequence[LabelCount]:
        return await self.get_list("/labels", LabelCount)

    async def recall(self, request: RecallRequest) -> RecallReply:
        return await self.post("/recall", request, RecallReply)

    async def looks(self, batch: LookBatch) -> None:
        await self.call("POST", "/looks", body=batch)

    async def views(self, label: str, limit: int) -> Sequence[View]:
        return await self.get_list("/views", View, label=label, limit=limit)

    async def objects(self, label: str | None, limit: int, room_id: int | None = None) -> Sequence[RememberedObject]:
        wanted = {key: value for key, value in (("label", label), ("room", room_id)) if value is not None}
        return await self.get_list("/objects", RememberedObject, limit=limit, **wanted)

    async def rooms(self) -> RoomsReply:
        return await self.get("/rooms", RoomsReply)

    async def room_grid(self) -> RoomGrid:
        return await self.get("/rooms/grid", RoomGrid)
