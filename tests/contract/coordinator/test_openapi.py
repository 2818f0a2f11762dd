"""Every route keeps what the OpenAPI document promises, for generated good and bad requests."""

import schemathesis
from hypothesis import settings
from schemathesis.checks import not_a_server_error
from schemathesis.specs.openapi.checks import allow_header_conformance

from coordinator.app import create_app
from coordinator.settings import Settings
from support.coordinator_world import FakeInference, FakeMemory, FakeRobot, World
from support.described import described_bus
from support.fake_clock import FakeClock
from support.generated_requests import DRAWN, NOT_PROMISED
from support.memory_log import MemoryLog

clock, bus = FakeClock(), described_bus()
world = World(clock, bus)
app = create_app(
    Settings(),
    bus=bus,
    robot=FakeRobot(world),
    inference=FakeInference(world),
    memory=FakeMemory(),
    clock=clock,
    log=MemoryLog(),
)
EXCLUDED = [
    *NOT_PROMISED,
    # The world stands still: what waits for the robot is a 503.
    not_a_server_error,
    # Starlette names in Allow only the methods of one of two routes on a path.
    allow_header_conformance,
]
schema = schemathesis.openapi.from_asgi("/openapi.json", app).exclude(path_regex="^/ready$")


@schema.parametrize()
@settings(DRAWN, max_examples=15)
def test_every_route_keeps_its_promise(case: schemathesis.Case) -> None:
    response = case.call()
    assert response.status_code != 500
    case.validate_response(response, excluded_checks=EXCLUDED)
