"""The robot's camera, read from robot_bridge by long-poll."""

from collections.abc import Mapping
from typing import Annotated

import httpx
from pydantic import Field, SecretStr, TypeAdapter

from contracts.base import StampS
from contracts.geometry import Pose2D
from contracts.measuring import LocalizeReply, LocalizeRequest, Measurement
from inference.ports import Frame
from mesh.errors import UpstreamError
from mesh.http import ServiceClient

SERVICE = "robot_bridge"
_STAMP_S = TypeAdapter[float](Annotated[StampS, Field(allow_inf_nan=False)])
NO_CONTENT = 204


class BridgeCamera(ServiceClient):
    """GET /camera/frame answers a JPEG with its stamp and pose in headers, or 204 when nothing newer came in time."""

    def __init__(
        self, base_url: str, *, key: SecretStr | None = None, transport: httpx.AsyncBaseTransport | None = None
    ) -> None:
        super().__init__(SERVICE, base_url, key=key, transport=transport)

    async def newest(self, *, after_s: float | None, wait_s: float) -> Frame | None:
        query = {"wait_s": wait_s} if after_s is None else {"after": after_s, "wait_s": wait_s}
        response = await self.call("GET", "/camera/frame", params=query, timeout_s=wait_s + 2.0)
        if response.status_code == NO_CONTENT:
            return None
        return frame_of(response.headers, response.content)

    async def localize(self, request: LocalizeRequest) -> tuple[Measurement, ...]:
        reply = await self.post("/localize", request, LocalizeReply)
        if len(reply.measurements) != len(request.boxes_xyxy):
            raise UpstreamError(SERVICE, 200, "not one measurement a box")
        return reply.measurements


def frame_of(headers: Mapping[str, str], jpeg: bytes) -> Frame:
    """Raises `UpstreamError` when the headers are not the contract: X-Stamp-S, and X-Pose 'x,y,yaw' or none."""
    try:
        stamp_s = _STAMP_S.validate_python(headers["x-stamp-s"])
        said = headers.get("x-pose", "").strip()
        pose = None
        if said:
            x, y, yaw = (float(part) for part in said.split(","))
            pose = Pose2D(x=x, y=y, yaw=yaw)
    except (KeyError, ValueError) as error:
        raise UpstreamError(SERVICE, 200, f"the frame's headers are not the contract: {error}") from error
    return Frame(stamp_s=stamp_s, jpeg=jpeg, pose=pose)
