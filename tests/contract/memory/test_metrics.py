"""What memory tells Prometheus."""

from memory.app import create_app
from memory.settings import Settings
from support.bus import MemoryBus
from support.fake_clock import FakeClock
from support.memory_store import FakeStore
from support.scraped import sample, scraped, untold

from .conftest import served


async def test_what_waits_is_told(store: FakeStore, bus: MemoryBus) -> None:
    async with served(create_app(Settings(robot_bridge_url=""), store=store, bus=bus, clock=FakeClock())) as client:
        told = await scraped(client.http)
    assert sample(told, "memory_frames_waiting", to="look") == 0
    assert untold(told, "memory") == set()
