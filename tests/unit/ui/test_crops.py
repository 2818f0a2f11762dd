"""What the page's client of the coordinator makes of a crop that is not there."""

import httpx
import pytest

from mesh.errors import NotFoundError, UpstreamError
from ui.adapters.coordinator import CoordinatorClient
from ui.settings import Settings


def client(status: int) -> CoordinatorClient:
    return CoordinatorClient(Settings(), transport=httpx.MockTransport(lambda _: httpx.Response(status)))


@pytest.mark.parametrize("status", [404, 422])
async def test_a_crop_that_was_never_kept_is_not_found(status: int) -> None:
    with pytest.raises(NotFoundError):
        await client(status).picture("m-1", 4893)


async def test_what_else_the_coordinator_refuses_is_its_own() -> None:
    with pytest.raises(UpstreamError):
        await client(403).picture("m-1", 4893)


@pytest.mark.parametrize(
    ("mission_id", "segment"), [("\0", "%00"), ("a/../b?c#d", "a%2F..%2Fb%3Fc%23d"), ("..", "%2E%2E"), ("ü", "%C3%BC")]
)
async def test_whatever_is_in_an_id_stays_in_its_segment_of_the_path(mission_id: str, segment: str) -> None:
    asked: list[str] = []

    def answer(request: httpx.Request) -> httpx.Response:
        asked.append(request.url.raw_path.decode())
        return httpx.Response(404)

    missions = CoordinatorClient(Settings(), transport=httpx.MockTransport(answer))
    with pytest.raises(NotFoundError):
        await missions.picture(mission_id, 3)
    assert asked == [f"/missions/{segment}/pictures/3"]
