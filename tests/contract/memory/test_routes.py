"""The service through its front door, over a store in a dict and a bus in memory."""

from collections.abc import AsyncIterator

import httpx
import pytest

from contracts.geometry import Pose2D
from contracts.memory import (
    DeletedReply,
    LabelCount,
    Observation,
    ObservationBatch,
    ObservationsReply,
    RecallReply,
    RecallRule,
    View,
)
from contracts.problem import Problem, Readiness
from contracts.topics import VISION_DETECTIONS
from contracts.vision import Detection, Detections
from memory.app import create_app
from memory.settings import Settings
from mesh.errors import UpstreamError
from mesh.http import ServiceClient
from support.bus import MemoryBus
from support.memory_store import FakeStore
from support.observations import asking, seen
from support.waiting import until

from .conftest import served

SETTINGS = Settings(flush_period_s=0.01, buffer_max=3, robot_bridge_url="")


@pytest.fixture
async def client(store: FakeStore, bus: MemoryBus) -> AsyncIterator[ServiceClient]:
    async with served(create_app(SETTINGS, bus=bus, store=store)) as opened:
        await until(lambda: bus.listened_to(VISION_DETECTIONS))
        yield opened


async def remember(client: ServiceClient, *observations: Observation) -> ObservationsReply:
    return await client.post("/observations", ObservationBatch(observations=observations), ObservationsReply)


def frame(*labels: str, x: float = 1.0, pose: bool = True) -> Detections:
    return Detections(
        stamp_s=3.0,
        image_width_px=250,
        image_height_px=250,
        pose=Pose2D(x=x, y=0.0, yaw=0.0) if pose else None,
        detections=tuple(Detection(label=one, confidence=0.8, bbox_xyxy=(0.0, 0.0, 9.0, 9.0)) for one in labels),
    )


async def test_what_was_told_is_listed_counted_and_recalled(client: ServiceClient) -> None:
    assert await remember(client, seen("bottle", colour="red"), seen("cup", x=2.0)) == ObservationsReply(stored=2)
    assert [one.label for one in await client.get_list("/labels", LabelCount)] == ["bottle", "cup"]
    assert [one.colour for one in await client.get_list("/views", View, label="bottle")] == ["red"]
    assert len(await client.get_list("/views", View, limit=1)) == 1
    request = asking("cup", memory_object="bottle", description="blue cup", rule=RecallRule.CONFIDENCE)
    answer = await client.post("/recall", request, RecallReply)
    assert [(one.view.label, one.source) for one in answer.views] == [("bottle", "memory_object"), ("cup", "label")]


async def test_people_are_counted_as_ignored_and_written_nowhere(
    client: ServiceClient, store: FakeStore, caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture[str]
) -> None:
    assert await remember(client, seen("person"), seen("cup")) == ObservationsReply(stored=1, ignored=1)
    assert await remember(client, seen("Person")) == ObservationsReply(stored=0, ignored=1)
    assert [one.label for batch in store.writes for one in batch] == ["cup"]
    assert "person" not in (caplog.text + "".join(capfd.readouterr())).lower()


async def test_detections_are_written_in_batches_but_not_people_nor_without_a_pose(
    client: ServiceClient, store: FakeStore, bus: MemoryBus
) -> None:
    await bus.publish(VISION_DETECTIONS, frame("vase", pose=False))
    await bus.publish(VISION_DETECTIONS, frame("person", "bottle"))
    await bus.publish(VISION_DETECTIONS, frame("cup"))
    await until(lambda: sum(len(batch) for batch in store.writes) == 2)
    assert {one.label for batch in store.writes for one in batch} == {"bottle", "cup"}


async def test_while_the_database_is_away_the_newest_detections_wait_and_are_written_later(
    client: ServiceClient, store: FakeStore, bus: MemoryBus
) -> None:
    store.away = "locked"
    await bus.publish(VISION_DETECTIONS, frame("bottle", x=0.0))
    for k in (1, 2, 3):
        await bus.publish(VISION_DETECTIONS, frame("cup", x=float(k)))
    await until(lambda: bus.idle(VISION_DETECTIONS))
    store.away = ""
    await until(lambda: bool(store.writes))
    assert [one.pose.x for batch in store.writes for one in batch] == [1.0, 2.0, 3.0]


async def test_what_waits_is_written_when_the_service_ends(store: FakeStore, bus: MemoryBus) -> None:
    async with served(create_app(Settings(flush_period_s=60.0, robot_bridge_url=""), bus=bus, store=store)):
        await until(lambda: bus.listened_to(VISION_DETECTIONS))
        await bus.publish(VISION_DETECTIONS, frame("bottle"))
        await until(lambda: bus.idle(VISION_DETECTIONS))
        assert store.writes == []
    assert [one.label for batch in store.writes for one in batch] == ["bottle"]
    assert store.closed


async def test_a_forgotten_label_does_not_come_back_from_what_waited(store: FakeStore, bus: MemoryBus) -> None:
    async with served(create_app(Settings(flush_period_s=60.0, robot_bridge_url=""), bus=bus, store=store)) as client:
        await until(lambda: bus.listened_to(VISION_DETECTIONS))
        await bus.publish(VISION_DETECTIONS, frame("bottle"))
        await until(lambda: bus.idle(VISION_DETECTIONS))
        assert await client.delete("/labels/bottle", DeletedReply) == DeletedReply(deleted=1)
    assert await store.views(None, 10) == []


@pytest.mark.parametrize("label", ["bottle", "a/b", "'; DROP TABLE views; --", "käse", "100%"])
async def test_a_label_is_forgotten_by_name_whatever_it_is(client: ServiceClient, label: str) -> None:
    await remember(client, seen(label), seen(label, x=1.0), seen("cup"))
    path = f"/labels/{httpx.QueryParams({'l': label})}".replace("l=", "", 1).replace("+", "%20")
    assert await client.delete(path, DeletedReply) == DeletedReply(deleted=2)
    assert [one.label for one in await client.get_list("/labels", LabelCount)] == ["cup"]


async def test_forgetting_what_was_never_seen_is_a_404_problem(client: ServiceClient) -> None:
    with pytest.raises(UpstreamError) as told:
        await client.delete("/labels/unicorn", DeletedReply)
    assert told.value.upstream_status == 404


OBSERVATION = '{"label": "cup", "confidence": 0.5, "pose": {"x": 0, "y": 0, "yaw": 0}, "stamp_s": 1}'


@pytest.mark.parametrize(
    ("method", "path", "body", "status"),
    [
        ("POST", "/observations", "{", 422),
        ("POST", "/observations", '{"observations": []}', 422),
        ("POST", "/observations", f'{{"observations": [{",".join([OBSERVATION] * 1001)}]}}', 422),
        ("POST", "/observations", f'{{"observations": [{OBSERVATION.replace("cup", "c" * 65)}]}}', 422),
        ("POST", "/observations", f'{{"observations": [{OBSERVATION.replace("cup", chr(92) + "u0007")}]}}', 422),
        ("POST", "/observations", f'{{"observations": [{OBSERVATION.replace("0.5", "NaN")}]}}', 422),
        ("POST", "/observations", f'{{"observations": [{OBSERVATION.replace("0.5", "1e999")}]}}', 422),
        ("POST", "/observations", " " * 2_000_000, 413),
        ("POST", "/recall", '{"target": {"label": "", "description": "x"}}', 422),
        ("POST", "/recall", '{"target": {"label": "cup", "description": "cup"}, "limit": 100000}', 422),
        ("GET", "/views?limit=0", "", 422),
        ("GET", "/views?limit=5001", "", 422),
        ("GET", "/views?label=", "", 422),
        ("GET", "/views?label=a%00b", "", 422),
        ("DELETE", "/labels/a%07b", "", 422),
        ("DELETE", "/labels/", "", 422),
        ("PUT", "/labels", "", 405),
    ],
)
async def test_bad_input_is_a_clear_problem_and_changes_nothing(
    client: ServiceClient, store: FakeStore, method: str, path: str, body: str, status: int
) -> None:
    answer = await client.http.request(method, path, content=body, headers={"content-type": "application/json"})
    assert answer.status_code == status
    assert answer.headers["content-type"] == "application/problem+json"
    assert Problem.model_validate_json(answer.content).status == status
    assert store.writes == []


async def test_a_database_that_is_away_is_a_503_that_names_it(client: ServiceClient, store: FakeStore) -> None:
    store.away = "database is locked"
    batch = ObservationBatch(observations=(seen(),)).model_dump_json()
    for method, path, body in (
        ("POST", "/observations", batch),
        ("GET", "/views", ""),
        ("GET", "/labels", ""),
        ("POST", "/recall", '{"target": {"label": "cup", "description": "cup"}}'),
        ("DELETE", "/labels/cup", ""),
    ):
        answer = await client.http.request(method, path, content=body, headers={"content-type": "application/json"})
        assert answer.status_code == 503
        assert answer.json()["detail"] == "database: database is locked"


async def test_ready_means_the_database_can_be_written_and_redis_is_there(
    client: ServiceClient, store: FakeStore, bus: MemoryBus
) -> None:
    assert (await client.http.get("/ready")).status_code == 200
    store.away, bus.connected = "read-only", False
    answer = await client.http.get("/ready")
    assert answer.status_code == 503
    told = Readiness.model_validate_json(answer.content).dependencies
    assert [(one.name, one.ok) for one in told] == [("database", False), ("robot.description", True), ("redis", False)]
