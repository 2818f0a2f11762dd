"""What an MCP client may read: the map and the camera as pictures, memory, the history and the state as JSON."""

import asyncio
import base64
import struct
import zlib
from collections.abc import Sequence
from typing import Final

import numpy as np
from mcp import types
from pydantic import TypeAdapter

from contracts.base import Message
from contracts.robot import Map
from coordinator.commands.mission_service import MissionService
from coordinator.ports import Camera, Memory, Robot
from geometry.grids import MapError, OccupancyGrid, decode
from mesh.errors import UnavailableError

OBJECTS_MAX: Final = 200
MISSIONS_MAX: Final = 20
FREE, OCCUPIED, UNKNOWN = 254, 0, 205
"""As map_server draws a map."""
LISTED: Final = {
    "atom://map": (
        "image/png",
        "The map: white is free floor, black is occupied, grey unknown; north of the map is up.",
    ),
    "atom://camera": ("image/jpeg", "The newest picture of the robot's camera."),
    "atom://objects": ("application/json", "The things that are remembered, with place, belief and room."),
    "atom://missions": ("application/json", "The newest missions, each with its report; newest first."),
    "atom://state": ("application/json", "What the robot is at now."),
}


class Resources:
    def __init__(self, *, missions: MissionService, robot: Robot, memory: Memory, camera: Camera) -> None:
        self._missions = missions
        self._robot = robot
        self._memory = memory
        self._camera = camera

    def listed(self) -> list[types.Resource]:
        return [
            types.Resource(uri=uri, name=uri.removeprefix("atom://"), mime_type=mime, description=told)
            for uri, (mime, told) in LISTED.items()
        ]

    async def read(self, uri: str) -> types.TextResourceContents | types.BlobResourceContents | None:
        """None for what is no resource. Raises `MeshError`."""
        match uri:
            case "atom://map":
                return _picture(uri, await self._map())
            case "atom://camera":
                return _picture(uri, await self._camera.frame())
            case "atom://objects":
                return _json(uri, await self._memory.objects(None, OBJECTS_MAX))
            case "atom://missions":
                return _json(uri, await self._missions.log.newest(MISSIONS_MAX))
            case "atom://state":
                return _json(uri, [self._missions.runner.status()])
            case _:
                return None

    async def _map(self) -> bytes:
        try:
            return await asyncio.to_thread(_drawn, await self._robot.map())
        except MapError as error:
            raise UnavailableError("robot_bridge", f"the map is malformed: {error}") from error


def _drawn(told: Map) -> bytes:
    """Seconds of work for the largest map: it keeps no loop from its ticks."""
    return png_of(decode(told))


def png_of(grid: OccupancyGrid) -> bytes:
    """One pixel a cell, 8 bit grey, the map's y axis up."""
    height, width = grid.cells.shape
    levels = np.full((height, width), UNKNOWN, np.uint8)
    levels[grid.free] = FREE
    levels[grid.occupied] = OCCUPIED
    rows = np.hstack([np.zeros((height, 1), np.uint8), levels[::-1]])  # each row begins with its filter: none
    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    parts = ((b"IHDR", header), (b"IDAT", zlib.compress(rows.tobytes(), 6)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(kind, data) for kind, data in parts)


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def _picture(uri: str, data: bytes) -> types.BlobResourceContents:
    return types.BlobResourceContents(uri=uri, mime_type=LISTED[uri][0], blob=base64.b64encode(data).decode("ascii"))


def _json(uri: str, some: Sequence[Message]) -> types.TextResourceContents:
    text = TypeAdapter(list[Message]).dump_json(list(some), serialize_as_any=True, exclude_none=True).decode()
    return types.TextResourceContents(uri=uri, mime_type=LISTED[uri][0], text=text)
