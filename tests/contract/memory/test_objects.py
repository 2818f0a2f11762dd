"""Objects, looks, recall, forgetting and exchange, through the front door."""

import json
from collections.abc import AsyncIterator

import numpy as np
import pytest

from contracts.geometry import Point3D, Pose2D
from contracts.measuring import Measurement
from contracts.memory import (
    Area,
    DeletedReply,
    ForgetRequest,
    ImportReply,
    LookBatch,
    LooksReply,
    MemoryStatistics,
    Observation,
    ObservationBatch,
    ObservationsReply,
    RecallReply,
    RememberedObject,
    View,
)
from contracts.topics import VISION_DETECTIONS
from contracts.vision import Detection, Detections
from geometry.grids import OccupancyGrid
from memory.app import create_app
from memory.settings import Settings
from mesh.errors import UpstreamError
from mesh.http import ServiceClient
from support.bus import MemoryBus
from support.fake_clock import FakeClock
from support.fake_senses import FakeSenses
from support.memory_store import FakeStore
from support.observations import asking, look, seen
from support.waiting import until, until_true

from .conftest import served

NOW_S = 1000.0
GROUND = OccupancyGrid(np.zeros((40, 40), np.int8), 0.1, Pose2D(x=-2.0, y=-2.0, yaw=0.0))


@pytest.fixture
def senses() -> FakeSenses:
    return FakeSenses(ground=GROUND)


@pytest.fixture
def clock() -> FakeClock:
    return FakeClock(NOW_S)


@pytest.fixture
async def client(
    store: FakeStore, bus: MemoryBus, senses: FakeSenses, clock: FakeClock
) -> AsyncIterator[ServiceClient]:
    app = create_app(Settings(), bus=bus, store=store, senses=senses, clock=clock)
    async with served(app) as opened:
        await until(lambda: bus.listened_to(VISION_DETECTIONS), timeout_s=30.0)
        yield opened


async def remember(client: ServiceClient, *observations: Observation) -> None:
    await client.post("/observations", ObservationBatch(observations=observations), ObservationsReply)


async def objects(client: ServiceClient, **query: object) -> list[RememberedObject]:
    return await client.get_list("/objects", RememberedObject, **query)


def bottle(x: float = 1.2, **known: object) -> Observation:
    return seen(at=(x, 0.0), confidence=0.9, stamp_s=NOW_S, **known)  # type: ignore[arg-type]


async def test_a_thing_that_was_seen_is_an_object_with_a_place_and_a_colour(client: ServiceClient) -> None:
    await remember(client, bottle(colour="red"))
    (thing,) = await objects(client, label="bottle", state="present", colour="red")
    assert (thing.description, thing.position.x, thing.times_seen) == ("red bottle", 1.2, 1)
    assert await client.get(f"/objects/{thing.id}", RememberedObject) == thing
    assert [one.object_id for one in await client.get_list("/views", View)] == [thing.id]
    assert await objects(client, colour="green") == []


async def test_a_look_that_should_show_it_and_does_not_costs_belief(client: ServiceClient) -> None:
    await remember(client, bottle())
    first = await client.post("/looks", LookBatch(looks=(look(stamp_s=NOW_S + 1.0),)), LooksReply)
    assert first == LooksReply(missed=1)
    (doubtful,) = await objects(client)
    other_side = look(2.4, 0.0, np.pi, stamp_s=NOW_S + 2.0)
    await client.post("/looks", LookBatch(looks=(other_side, other_side)), LooksReply)
    (lost,) = await objects(client)
    assert 0.9 > doubtful.belief > 0.3 > lost.belief
    assert (lost.state.value, lost.times_missed) == ("lost", 3)
    recalled = await client.post("/recall", asking("bottle"), RecallReply)
    assert recalled.views == ()


async def test_a_hidden_thing_keeps_its_belief(client: ServiceClient, senses: FakeSenses) -> None:
    await remember(client, bottle())
    (before,) = await objects(client)
    senses.far_m = 0.6
    reply = await client.post("/looks", LookBatch(looks=(look(stamp_s=NOW_S + 1.0, far_m=None),)), LooksReply)
    assert reply == LooksReply(undetermined=1)
    assert await objects(client) == [before]


@pytest.mark.parametrize("away_m", [7.5, 12.0, 20.0])
async def test_a_thing_far_away_is_remembered_however_unsure_its_place_is_and_ends_nothing(
    client: ServiceClient, bus: MemoryBus, store: FakeStore, clock: FakeClock, away_m: float
) -> None:
    sigma_m = 0.012 * away_m**3.461  # what robot_bridge says of such a distance
    place = Measurement(distance_m=away_m, sigma_m=sigma_m, map_point=Point3D(x=away_m, y=0.0, z=0.3))
    message = Detections(
        stamp_s=NOW_S + 1.0,
        image_width_px=250,
        image_height_px=250,
        pose=Pose2D(x=0.0, y=0.0, yaw=0.0),
        detections=(Detection(label="cup", confidence=0.8, bbox_xyxy=(120.0, 120.0, 124.0, 124.0), measurement=place),),
    )
    await bus.publish(VISION_DETECTIONS, message)

    async def remembered() -> bool:
        await clock.advance(2.0)
        return len(store.frames) == 1

    await until_true(remembered)
    assert [one.sigma_m for frame in store.frames for one in frame.seen] == [sigma_m]
    assert [one.label for one in await client.get_list("/views", View)] == ["cup"]


async def test_every_frame_is_sightings_with_places_and_a_look(
    client: ServiceClient, bus: MemoryBus, senses: FakeSenses, store: FakeStore, clock: FakeClock
) -> None:
    await remember(client, bottle())
    place = Measurement(distance_m=1.4, sigma_m=0.05, map_point=Point3D(x=1.4, y=-0.5, z=0.3))
    message = Detections(
        stamp_s=NOW_S + 1.0,
        image_width_px=250,
        image_height_px=250,
        pose=Pose2D(x=0.0, y=0.0, yaw=0.0),
        detections=(
            Detection(label="cup", confidence=0.8, bbox_xyxy=(200.0, 120.0, 220.0, 140.0), measurement=place),
            Detection(label="person", confidence=0.9, bbox_xyxy=(0.0, 0.0, 40.0, 250.0)),
        ),
    )
    await bus.publish(VISION_DETECTIONS, message)
    await until(lambda: len(senses.asked) == 1, timeout_s=30.0)
    await clock.advance(2.0)
    await until(lambda: len(store.frames) == 2, timeout_s=30.0)
    cup, missed = sorted(await objects(client), key=lambda one: one.label, reverse=True)
    assert (cup.label, cup.position.x, missed.label, missed.times_missed) == ("cup", 1.4, "bottle", 1)
    assert [(one.label, one.sigma_m) for frame in store.frames for one in frame.seen][1] == ("cup", 0.05)
    assert senses.asked[0].stamp_s == NOW_S + 1.0


async def test_all_that_is_missing_from_a_look_is_measured_in_one_call(
    client: ServiceClient, senses: FakeSenses
) -> None:
    await remember(client, bottle(), seen("cup", 1.2, at=(1.2, 0.1), stamp_s=NOW_S))
    reply = await client.post("/looks", LookBatch(looks=(look(stamp_s=NOW_S + 1.0, far_m=None),)), LooksReply)
    assert reply == LooksReply(missed=2)
    assert [len(one.boxes_xyxy) for one in senses.asked] == [2]


async def test_recall_says_where_to_go_what_is_there_and_why(client: ServiceClient) -> None:
    await remember(client, bottle(colour="red"), seen("bottle", 3.0, at=(4.0, 0.5), colour="green", stamp_s=NOW_S))
    request = asking("bottle", description="red bottle", pose=Pose2D(x=0.0, y=0.0, yaw=0.0))
    reply = await client.post("/recall", request, RecallReply)
    best, other = reply.views
    assert reply.rule.value == "belief"
    assert best.thing is not None
    assert (best.thing.colour, best.pose) == ("red", Pose2D(x=0.0, y=0.0, yaw=0.0))
    assert best.score > other.score
    assert best.parts is not None
    assert (best.parts.agreement, best.parts.relation, best.parts.travel) == (1.0, 1.0, 1.0)


async def test_things_are_forgotten_by_id_area_and_time(client: ServiceClient) -> None:
    await remember(client, bottle(), bottle(3.0), seen("cup", 5.0, at=(6.0, 0.0), stamp_s=1.0))
    (first, second) = await objects(client, label="bottle")
    assert await client.delete(f"/objects/{first.id}", DeletedReply) == DeletedReply(deleted=2)
    with pytest.raises(UpstreamError) as told:
        await client.delete(f"/objects/{first.id}", DeletedReply)
    assert told.value.upstream_status == 404
    around = Area(x_min=-1.0, y_min=-1.0, x_max=3.5, y_max=1.0)
    assert (await client.post("/forget", ForgetRequest(area=around), DeletedReply)).deleted == 2
    assert (await client.post("/forget", ForgetRequest(seen_before_s=2.0), DeletedReply)).deleted == 2
    assert await objects(client) == []
    assert second.id


async def test_an_export_brought_back_is_the_same_memory_and_twice_is_once(client: ServiceClient) -> None:
    await remember(client, bottle(colour="red"), bottle(3.0), seen("cup", 5.0, stamp_s=NOW_S))
    exported = await client.http.get("/export")
    assert exported.headers["content-type"].startswith("application/x-ndjson")
    before = await client.get_list("/views", View), await objects(client)
    for label in ("bottle", "cup"):
        await client.delete(f"/labels/{label}", DeletedReply)
    for _ in range(2):
        answer = await client.http.post("/import", content=exported.content)
        assert ImportReply.model_validate_json(answer.content) == ImportReply(objects=2, views=3)
    views, things = await client.get_list("/views", View), await objects(client)
    gone = {"id": 0, "object_id": None}
    assert [one.model_copy(update=gone) for one in views] == [one.model_copy(update=gone) for one in before[0]]
    own = {"id": 0, "room_id": None}  # its room is of the map, which is cut in the background
    assert [one.model_copy(update=own) for one in things] == [one.model_copy(update=own) for one in before[1]]


async def test_the_documents_form_goes_out_and_comes_in(client: ServiceClient) -> None:
    records = [{"x": 1.0, "y": 2.0, "yaw": 7.0, "confidence": 0.8, "time": 5.0}]
    written = json.dumps({"bottle": records, "Person": records})
    answer = await client.http.post("/import?form=seeds", content=written)
    assert ImportReply.model_validate_json(answer.content) == ImportReply(objects=0, views=1, ignored=1)
    exported = (await client.http.get("/export?form=seeds")).json()
    (one,) = exported["bottle"]
    assert (one["x"], one["confidence"], one["time"]) == (1.0, 0.8, 5.0)
    assert one["yaw"] == pytest.approx(7.0 - 2.0 * np.pi)
    assert list(exported) == ["bottle"]


HEADER = '{"kind": "header", "format": "atom-memory", "version": 1}\n'


@pytest.mark.parametrize(
    ("form", "content", "told"),
    [
        ("full", "", "the header is missing"),
        ("full", "nonsense", "line 1"),
        ("full", HEADER + HEADER, "line 2: the header must be the first line"),
        ("full", HEADER + '{"kind": "view", "label": "cup"}', "line 2: "),
        ("full", HEADER.replace("1", "3"), "line 1: "),
        ("seeds", "[]", "should be an object"),
        ("seeds", '{"cup": [{"x": NaN, "y": 0, "yaw": 0, "confidence": 1, "time": 0}]}', "cup.0.x"),
        ("seeds", '{"a\\u0000b": []}', "pattern"),
    ],
)
async def test_what_is_no_export_is_refused_and_changes_nothing(
    client: ServiceClient, form: str, content: str, told: str
) -> None:
    answer = await client.http.post(f"/import?form={form}", content=content)
    assert answer.status_code == 422
    assert told in answer.json()["detail"]
    assert await client.get_list("/views", View) == []


async def test_the_map_shows_objects_by_belief_and_escapes_their_names(client: ServiceClient) -> None:
    await remember(client, bottle(), seen("<script>", at=(1.0, 1.0), stamp_s=NOW_S))
    answer = await client.http.get("/map.svg")
    assert answer.headers["content-type"].startswith("image/svg+xml")
    assert 'data-state="present"' in answer.text
    assert "<script>" not in answer.text
    assert "bottle 9" in answer.text


async def test_statistics_count_what_there_is(client: ServiceClient) -> None:
    await remember(client, bottle(), bottle(), seen("cup", 5.0, stamp_s=2.0))
    found = await client.get("/statistics", MemoryStatistics)
    assert (found.labels, found.views, found.sightings) == (2, 3, 3)
    assert sum(found.objects.values()) == 2
    assert (found.oldest_s, found.newest_s) == (2.0, NOW_S)


@pytest.mark.parametrize(
    ("method", "path", "body"),
    [
        ("POST", "/looks", '{"looks": []}'),
        ("POST", "/forget", "{}"),
        ("POST", "/forget", '{"area": {"x_min": 1, "y_min": 0, "x_max": 0, "y_max": 1}}'),
        ("GET", "/objects/0", ""),
        ("GET", "/objects/99999999999999999999", ""),
        ("DELETE", "/objects/abc", ""),
        ("GET", "/objects?state=gone", ""),
        ("GET", "/export?form=xml", ""),
    ],
)
async def test_what_makes_no_sense_is_a_422_problem(client: ServiceClient, method: str, path: str, body: str) -> None:
    answer = await client.http.request(method, path, content=body, headers={"content-type": "application/json"})
    assert answer.status_code == 422
    assert answer.headers["content-type"] == "application/problem+json"


async def test_an_export_of_a_database_that_is_away_is_a_503_not_half_a_file(
    client: ServiceClient, store: FakeStore
) -> None:
    store.away = "database is locked"
    for form in ("full", "seeds"):
        assert (await client.http.get(f"/export?form={form}")).status_code == 503
