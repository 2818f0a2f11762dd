"""The camera's newest picture, from robot_bridge over HTTP."""

import httpx

from coordinator.settings import Settings
from mesh.http import ServiceClient


class CameraClient(ServiceClient):
    """The port `Camera`, for real."""

    def __init__(self, settings: Settings, *, transport: httpx.AsyncBaseTransport | None = None) -> None:
        super().__init__(
            "robot_bridge",
            settings.robot_bridge_url,
            key=settings.own_key,
            timeout_s=settings.call_timeout_s,
            transport=transport,
        )

    async def frame(self) -> bytes:
        return (await self.call("GET", "/camera/frame")).content
