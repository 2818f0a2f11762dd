"""Every route keeps what the OpenAPI document promises, for generated good and bad requests."""

import tempfile
from pathlib import Path

import schemathesis
from hypothesis import settings
from schemathesis.specs.openapi.checks import allow_header_conformance

from robot_bridge.app import create_app
from robot_bridge.settings import Settings
from support.bus import MemoryBus
from support.fake_robot import FakeRobot
from support.generated_requests import DRAWN, NOT_PROMISED
from support.toy_robot import ToyRobot

folder = tempfile.TemporaryDirectory(prefix="atom-openapi-")  # removed with the process
(Path(folder.name) / "emergency_stop.json").write_text("{")  # torn, so latched: nothing that is generated drives
bridge_settings = Settings(state_dir=Path(folder.name), scan_age_s_max=60.0)
app = create_app(bridge_settings, bus=MemoryBus(), robot=FakeRobot(ToyRobot()))
# Left out: what by its nature goes on for longer than a generated test may take (test_connections and test_bad_input
# look after those), and /ready, which is 503 as soon as a busy machine keeps a sensor waiting.
schema = schemathesis.openapi.from_asgi("/openapi.json", app).exclude(path_regex="^/(rotate|drive|ready|camera/.*)$")


@schema.parametrize()
@settings(DRAWN, max_examples=10)
def test_every_route_keeps_its_promise(case: schemathesis.Case) -> None:
    # Starlette names in Allow only the methods of one of two routes on a path.
    case.call_and_validate(excluded_checks=[*NOT_PROMISED, allow_header_conformance])
