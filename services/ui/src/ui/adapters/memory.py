"""memory over HTTP: what is remembered, forgetting, and carrying it elsewhere."""

from collections.abc import Sequence

import httpx

from contracts.memory import DeletedReply, ImportReply, LabelCount, RememberedObject, View
from contracts.rooms import NamedRoom, NameRoom, RoomGrid, RoomsReply
from mesh.http import ServiceClient, path_of
from ui.settings import Settings

OBJECTS_MAX = 500
VIEWS_MAX = 1000


class MemoryClient(ServiceClient):
    """The port `Memory`, for real."""

    def __init__(self, settings: Settings, *, transport: httpx.AsyncBaseTransport | None = None) -> None:
        super().__init__(
            "memory", settings.memory_url, key=settings.own_key, timeout_s=settings.call_timeout_s, transport=transport
        )
        self._transfer_timeout_s = settings.transfer_timeout_s

    async def labels(self) -> Sequence[LabelCount]:
        return await self.get_list("/labels", LabelCount)

    async def objects(self) -> Sequence[RememberedObject]:
        return await self.get_list("/objects", RememberedObject, limit=OBJECTS_MAX)

    async def views(self) -> Sequence[View]:
        return await self.get_list("/views", View, limit=VIEWS_MAX)

    async def rooms(self) -> RoomsReply:
        return await self.get("/rooms", RoomsReply)

    async def room_grid(self) -> RoomGrid:
        return await self.get("/rooms/grid", RoomGrid)

    async def name_room(self, room_id: int, name: str) -> NamedRoom:
        return await self.put(f"/rooms/{room_id}/name", NameRoom(name=name), NamedRoom)

    async def forget_object(self, object_id: int) -> int:
        return (await self.delete(f"/objects/{object_id}", DeletedReply)).deleted

    async def forget_label(self, label: str) -> int:
        return (await self.delete(path_of("labels", label), DeletedReply)).deleted

    async def export(self) -> bytes:
        return (await self.call("GET", "/export", timeout_s=self._transfer_timeout_s)).content

    async def import_(self, data: bytes) -> ImportReply:
        return await self.post("/import", data, ImportReply, timeout_s=self._transfer_timeout_s)
