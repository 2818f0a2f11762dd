"""What is remembered belongs to the map the robot is in: through the front door."""

import json

import pytest

from contracts.memory import ImportReply, LabelCount, RecallReply, RememberedMap, RememberedObject
from contracts.robot import EmergencyStop, KnownMap, RobotState
from contracts.topics import ROBOT_STATE
from memory.app import create_app
from memory.settings import Settings
from mesh.http import ServiceClient
from support.bus import MemoryBus
from support.fake_senses import FakeSenses
from support.memory_store import FakeStore
from support.observations import asking, seen
from support.waiting import until_true

from .conftest import served

ASK = asking("cup", description="red cup")


def state(map_id: str | None) -> RobotState:
    return RobotState(stamp_s=1.0, map_id=map_id, emergency_stop=EmergencyStop(latched=False, epoch=0))


async def remember(client: ServiceClient, x: float) -> None:
    one = seen("cup", x=x, colour="red", at=(x + 1.0, 0.0))
    answer = await client.http.post("/observations", json={"observations": [one.model_dump()]})
    assert answer.status_code == 200


async def recalled(client: ServiceClient) -> RecallReply:
    return await client.post("/recall", ASK, RecallReply)


async def test_in_another_map_old_places_are_kept_apart_and_said(bus: MemoryBus, store: FakeStore) -> None:
    app = create_app(Settings(robot_bridge_url=""), bus=bus, store=store)
    async with served(app) as client:

        async def robot_goes_to(map_id: str) -> None:
            await bus.publish(ROBOT_STATE, state(map_id))
            await until_true(lambda: _is_in(client, map_id))

        await robot_goes_to("home")
        await remember(client, 3.0)
        await robot_goes_to("office")
        reply = await recalled(client)
        assert (reply.views, reply.map_id, reply.in_other_maps) == ((), "office", ("home",))
        assert await _labels(client) == []
        assert [one.label for one in await _labels(client, "?map=home")] == ["cup"]
        told = [RememberedObject.model_validate(o) for o in (await client.http.get("/objects?map=home")).json()]
        assert [one.position.x for one in told] == [4.0]
        assert (await client.http.get("/objects")).json() == []
        assert (await client.http.get("/views?map=nowhere")).status_code == 404
        await remember(client, 5.0)
        await robot_goes_to("home")
        reply = await recalled(client)
        assert [one.view.pose.x for one in reply.views] == [3.0]
        assert (reply.map_id, reply.in_other_maps) == ("home", ("office",))
        maps = [RememberedMap.model_validate(one) for one in (await client.http.get("/maps")).json()]
        assert [(one.id, one.current, one.views, one.objects) for one in maps] == [
            ("home", True, 1, 1),
            ("office", False, 1, 1),
        ]


async def _is_in(client: ServiceClient, map_id: str) -> bool:
    return (await recalled(client)).map_id == map_id


async def _labels(client: ServiceClient, query: str = "") -> list[LabelCount]:
    return [LabelCount.model_validate(one) for one in (await client.http.get(f"/labels{query}")).json()]


async def test_the_bridge_is_asked_where_the_bus_is_silent_and_says_what_a_map_was(store: FakeStore) -> None:
    senses = FakeSenses()
    await store.enter_map("emptied", (), 0.5)
    senses.home_of = KnownMap(id="home", was=("emptied",), first_seen_s=0.0, last_seen_s=1.0)
    app = create_app(Settings(), bus=MemoryBus(), store=store, senses=senses)
    async with served(app) as client:
        await until_true(lambda: _is_in(client, "home"))
        assert [one.id for one in await store.maps()] == ["home"]


async def test_after_a_restart_without_a_bridge_it_is_where_it_was_last(store: FakeStore) -> None:
    await store.enter_map("home", (), 1.0)
    await store.enter_map("office", (), 2.0)
    async with served(create_app(Settings(robot_bridge_url=""), bus=MemoryBus(), store=store)) as client:
        assert (await recalled(client)).map_id == "office"


@pytest.mark.parametrize("version", [1, 2])
async def test_an_export_without_maps_is_of_the_map_the_robot_is_in(store: FakeStore, version: int) -> None:
    office = await store.enter_map("home", (), 1.0), await store.enter_map("office", (), 2.0)
    async with served(create_app(Settings(robot_bridge_url=""), bus=MemoryBus(), store=store)) as client:
        header = {"kind": "header", "format": "atom-memory", "version": version}
        view = {"kind": "view", "label": "cup", "colour": "red", "x": 1.0, "y": 0.0, "yaw": 0.0, "confidence": 0.9,
                "last_seen_s": 5.0, "count": 1, "belief": 0.9, "believed_s": 5.0, "thing_id": None}  # fmt: skip
        body = "\n".join(json.dumps(line) for line in (header, view)).encode()
        answer = await client.http.post("/import", content=body)
        assert ImportReply.model_validate(answer.json()).views == 1
        assert [view.map_number for view in await store.views(None, 10)] == [office[1]]


async def test_an_import_of_a_map_that_is_not_in_it_is_refused(store: FakeStore) -> None:
    async with served(create_app(Settings(robot_bridge_url=""), bus=MemoryBus(), store=store)) as client:
        await remember(client, 1.0)
        lines = (await client.http.get("/export")).text.replace('"map_number": 0', '"map_number": 7')
        refused = await client.http.post("/import", content=lines.encode())
        assert (refused.status_code, "map 7, which is not above it" in refused.json()["detail"]) == (422, True)
