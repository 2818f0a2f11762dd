"""Every route keeps what the OpenAPI document promises, for generated good and bad requests."""

import schemathesis
from hypothesis import HealthCheck, Phase, settings
from schemathesis.checks import not_a_server_error
from schemathesis.specs.openapi.checks import (
    ignored_auth,
    missing_required_header,
    negative_data_rejection,
    positive_data_acceptance,
)

from inference.app import create_app
from inference.ports import Frame
from inference.settings import Settings
from support.bus import MemoryBus
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
# A body may be well-formed and still make no sense (an empty box, an image that is none): 422. A stamp beyond all
# frames is a 504, and models still load at first: 503. Pydantic takes "1" for 1.
# The app has no keys here, so that no door is shut: tests/contract/access knocks at each with keys.
NOT_PROMISED = [
    ignored_auth,
    missing_required_header,
    negative_data_rejection,
    positive_data_acceptance,
    not_a_server_error,
]


@schema.parametrize()
@settings(
    max_examples=12,
    deadline=None,
    derandomize=True,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow],
)
def test_every_route_keeps_its_promise(case: schemathesis.Case) -> None:
    response = case.call()
    assert response.status_code != 500
    case.validate_response(response, excluded_checks=NOT_PROMISED)
