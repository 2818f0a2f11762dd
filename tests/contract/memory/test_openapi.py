"""Every route keeps what the OpenAPI document promises, for generated good and bad requests."""

import schemathesis
from hypothesis import settings
from schemathesis.specs.openapi.checks import allow_header_conformance

from memory.app import create_app
from memory.settings import Settings
from support.described import described_bus
from support.generated_requests import DRAWN, NOT_PROMISED
from support.memory_store import FakeStore

app = create_app(Settings(robot_bridge_url=""), bus=described_bus(), store=FakeStore())
# Starlette names in Allow only the methods of one of two routes on a path.
EXCLUDED = [*NOT_PROMISED, allow_header_conformance]
schema = schemathesis.openapi.from_asgi("/openapi.json", app)


@schema.parametrize()
@settings(DRAWN, max_examples=12)
def test_every_route_keeps_its_promise(case: schemathesis.Case) -> None:
    case.call_and_validate(excluded_checks=EXCLUDED)
