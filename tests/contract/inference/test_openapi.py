"""Every route keeps what the OpenAPI document promises, for generated good and bad requests."""

import schemathesis
from hypothesis import settings
from schemathesis.checks import not_a_server_error

from inference.app import create_app
from inference.ports import Frame
from inference.settings import Settings
from support.bus import MemoryBus
from support.generated_requests import DRAWN, NOT_PROMISED
from support.inference_fakes import FakeCamera, FakeClip, FakeDetector, bottle, jpeg_of, loads, picture


class EagerCamera(FakeCamera):
    """Always has a newer frame."""

    async def newest(self, *, after_s: float | None, wait_s: float) -> Frame | None:
        return Frame((after_s or 0.0) + 1.0, jpeg_of(picture()))


app = create_app(
    Settings(),
    bus=MemoryBus(),
    camera=EagerCamera(),
    models=loads(detector=FakeDetector((bottle(),)), clip=FakeClip()),
)
schema = schemathesis.openapi.from_asgi("/openapi.json", app)
# A stamp beyond all frames is a 504, and models still load at first: 503.
EXCLUDED = [*NOT_PROMISED, not_a_server_error]


@schema.parametrize()
@settings(DRAWN, max_examples=12)
def test_every_route_keeps_its_promise(case: schemathesis.Case) -> None:
    response = case.call()
    assert response.status_code != 500
    case.validate_response(response, excluded_checks=EXCLUDED)
