"""The camera adapter against a stand-in of robot_bridge's GET /camera/frame."""

from collections.abc import Callable

import httpx
import pytest

from contracts.geometry import Pose2D
from contracts.measuring import LocalizeReply, LocalizeRequest, Measurement
from inference.adapters.bridge_camera import BridgeCamera
from inference.ports import Frame
from mesh.errors import MeshError, ServiceTimeoutError, UnavailableError, UpstreamError

Answer = Callable[[httpx.Request], httpx.Response]
HEADERS = {"X-Stamp-S": "12.250000", "X-Pose": "1.5,-2.0,0.25", "X-Width": "250", "X-Height": "250"}


async def newest(answer: Answer, after_s: float | None = None) -> Frame | None:
    camera = BridgeCamera("http://bridge", transport=httpx.MockTransport(answer))
    try:
        return await camera.newest(after_s=after_s, wait_s=1.0)
    finally:
        await camera.aclose()


async def test_a_frame_comes_with_stamp_and_pose() -> None:
    frame = await newest(lambda _: httpx.Response(200, headers=HEADERS, content=b"jpeg"))
    assert frame == Frame(12.25, b"jpeg", Pose2D(x=1.5, y=-2.0, yaw=0.25))


@pytest.mark.parametrize("headers", [{"X-Stamp-S": "1"}, {"X-Stamp-S": "1", "X-Pose": ""}])
async def test_a_robot_that_is_not_localised_has_no_pose(headers: dict[str, str]) -> None:
    frame = await newest(lambda _: httpx.Response(200, headers=headers, content=b"jpeg"))
    assert frame is not None
    assert frame.pose is None


async def test_it_asks_for_what_is_newer_and_says_how_long_it_waits() -> None:
    asked: list[str] = []

    def answer(request: httpx.Request) -> httpx.Response:
        asked.append(str(request.url.copy_with(host="bridge")))
        return httpx.Response(204)

    assert await newest(answer) is None
    assert await newest(answer, after_s=12.25) is None
    assert asked == ["http://bridge/camera/frame?wait_s=1.0", "http://bridge/camera/frame?after=12.25&wait_s=1.0"]


def refused(_: httpx.Request) -> httpx.Response:
    raise httpx.ConnectError("refused")


def slow(_: httpx.Request) -> httpx.Response:
    raise httpx.ReadTimeout("slow")


@pytest.mark.parametrize(
    ("answer", "error"),
    [
        (refused, UnavailableError),
        (slow, ServiceTimeoutError),
        (lambda _: httpx.Response(503, json={"detail": "no frame yet"}), UnavailableError),
        (lambda _: httpx.Response(404), UpstreamError),
        (lambda _: httpx.Response(200, content=b"jpeg"), UpstreamError),
        (lambda _: httpx.Response(200, headers={"X-Stamp-S": "soon"}), UpstreamError),
        (lambda _: httpx.Response(200, headers={"X-Stamp-S": "nan"}), UpstreamError),
        (lambda _: httpx.Response(200, headers={"X-Stamp-S": "-1"}), UpstreamError),
        (lambda _: httpx.Response(200, headers={"X-Stamp-S": "inf"}), UpstreamError),
        (lambda _: httpx.Response(200, headers={"X-Stamp-S": "1", "X-Pose": "1,2"}), UpstreamError),
        (lambda _: httpx.Response(200, headers={"X-Stamp-S": "1", "X-Pose": "1,2,nan"}), UpstreamError),
    ],
)
async def test_trouble_has_a_name(answer: Answer, error: type[MeshError]) -> None:
    with pytest.raises(error):
        await newest(answer)


async def localized(answer: Answer) -> tuple[Measurement, ...]:
    camera = BridgeCamera("http://bridge", transport=httpx.MockTransport(answer))
    boxes = ((1.0, 2.0, 3.0, 4.0), (5.0, 6.0, 7.0, 8.0))
    try:
        return await camera.localize(LocalizeRequest(boxes_xyxy=boxes, image_width_px=250, image_height_px=250))
    finally:
        await camera.aclose()


async def test_boxes_are_localized_in_one_call_in_their_order() -> None:
    asked: list[str] = []

    def answer(request: httpx.Request) -> httpx.Response:
        asked.append(request.url.path)
        boxes = LocalizeRequest.model_validate_json(request.content).boxes_xyxy
        found = tuple(Measurement(distance_m=box[0]) for box in boxes)
        return httpx.Response(200, text=LocalizeReply(measurements=found).model_dump_json())

    assert [one.distance_m for one in await localized(answer)] == [1.0, 5.0]
    assert asked == ["/localize"]


async def test_an_answer_with_another_number_of_measurements_is_not_the_contract() -> None:
    with pytest.raises(UpstreamError, match="not one measurement a box"):
        await localized(lambda _: httpx.Response(200, json={"measurements": [{}]}))
