"""The live view for Foxglove, heard by a client of its protocol: what it shows, what it refuses, what it drops."""

import asyncio
import json
import os
import socket
import threading
import time
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import ClassVar, cast

import pytest
from asgi_lifespan import LifespanManager
from foxglove.websocket import ChannelView, Client
from mcap.well_known import MessageEncoding, SchemaEncoding
from structlog.testing import capture_logs
from websockets.asyncio.client import connect
from websockets.exceptions import InvalidStatus

from contracts.robot import RobotState
from contracts.topics import ALL_TOPICS, VISION_DETECTIONS
from contracts.vision import Detection, Detections
from robot_bridge.adapters.foxglove import (
    BACKLOG_MAX,
    CLOSE_S_MAX,
    WAITING_BYTES_MAX,
    WAITING_MAX,
    FoxgloveView,
    open_foxglove,
)
from robot_bridge.app import create_app
from robot_bridge.ports import Kind, Raw
from robot_bridge.recording.ros_topics import ros_topics
from robot_bridge.settings import RosSettings, Settings
from support.bridge_behaviour import Rig, running
from support.bus import MemoryBus
from support.fake_robot import FakeRobot
from support.foxglove_client import foxglove_client
from support.toy_robot import ToyRobot
from support.waiting import until

SCAN = Kind("sensor_msgs/msg/LaserScan", MessageEncoding.CDR, SchemaEncoding.ROS2, b"float32 range_max")


PICTURE_BYTES = 921_600
"""Of 640 times 480 pixels, each three bytes."""


def rss_bytes() -> int:
    """Of this process, where the server is."""
    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * os.sysconf("SC_PAGE_SIZE")


def scan(number: int, size: int = 8) -> Raw:
    return Raw("/scan", SCAN, number, number.to_bytes(8) + bytes(size - 8))


@pytest.fixture
def view() -> Iterator[FoxgloveView]:
    view = open_foxglove(0)
    yield view
    view.close()


@pytest.fixture
async def shown(tmp_path: Path, view: FoxgloveView) -> AsyncIterator[Rig]:
    """A bridge whose live view is `view`."""
    toy = ToyRobot()
    async with running(tmp_path, toy, FakeRobot(toy), live_view=view) as rig:
        yield rig


async def test_the_state_of_the_robot_is_shown_with_the_schema_that_reads_it(shown: Rig, view: FoxgloveView) -> None:
    async with foxglove_client(view.port) as client:
        await client.advertised("robot.state")
        channel = client.channels["robot.state"]
        assert (channel["encoding"], channel["schemaEncoding"]) == ("json", "jsonschema")
        assert channel["schemaName"] == "RobotState"
        assert json.loads(channel["schema"])["type"] == "object"
        await client.subscribe("robot.state")
        assert RobotState.model_validate_json(await client.next_of("robot.state")).stamp_s > 0.0


async def test_people_are_not_shown(shown: Rig, view: FoxgloveView) -> None:
    await until(lambda: shown.bus.listened_to(VISION_DETECTIONS))
    seen = tuple(
        Detection(label=label, confidence=0.9, bbox_xyxy=(0.0, 0.0, 9.0, 9.0)) for label in ("person", "bottle")
    )
    await shown.bus.publish(
        VISION_DETECTIONS, Detections(stamp_s=1.0, image_width_px=250, image_height_px=250, detections=seen)
    )
    async with foxglove_client(view.port) as client:
        await client.advertised("vision.detections")
        await client.subscribe("vision.detections")
        told = Detections.model_validate_json(await client.next_of("vision.detections"))
    assert [each.label for each in told.detections] == ["bottle"]


async def test_who_comes_late_is_told_what_was_said_once(view: FoxgloveView) -> None:
    view.show(scan(7))
    async with foxglove_client(view.port) as client:
        await client.advertised("/scan")
        assert client.channels["/scan"]["schema"] == "float32 range_max"
        await client.subscribe("/scan")
        assert await client.next_of("/scan") == (7).to_bytes(8)
    async with foxglove_client(view.port) as later:
        await later.advertised("/scan")
        await later.subscribe("/scan")
        assert await later.next_of("/scan") == (7).to_bytes(8)
        assert later.heard[0][1] == 7


class SlowToSubscribe:
    """A channel that loses what is logged before `subscribed_s`, as the SDK's does what is logged in `on_subscribe`."""

    subscribed_s: ClassVar[float] = 0.0
    heard: ClassVar[list[bytes]] = []

    def __init__(self, topic: str, **_: object) -> None:
        self.topic = topic

    def log(self, data: bytes, **_: object) -> None:
        if time.monotonic() >= self.subscribed_s:
            self.heard.append(data)


async def test_a_client_that_is_on_its_channel_only_after_it_was_told_of_is_told_all_the_same(
    view: FoxgloveView, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("foxglove.Channel", SlowToSubscribe)
    monkeypatch.setattr(SlowToSubscribe, "subscribed_s", time.monotonic() + 0.05)
    monkeypatch.setattr(SlowToSubscribe, "heard", [])
    view.show(scan(7))
    view.on_subscribe(cast("Client", None), cast("ChannelView", SimpleNamespace(topic="/scan")))
    await until(lambda: SlowToSubscribe.heard)
    assert set(SlowToSubscribe.heard) == {(7).to_bytes(8)}


@pytest.mark.parametrize(
    "asked",
    [
        {"op": "advertise", "channels": [{"id": 1, "topic": "/cmd_vel", "encoding": "json", "schemaName": "Twist"}]},
        {"op": "setParameters", "parameters": [{"name": "speed", "value": 9}], "id": "1"},
        {"op": "getParameters", "parameterNames": [], "id": "1"},
        {"op": "fetchAsset", "uri": "file:///etc/hostname", "requestId": 1},
        {"op": "subscribeConnectionGraph"},
    ],
)
async def test_it_is_to_be_looked_at_and_no_more(view: FoxgloveView, asked: dict[str, object]) -> None:
    async with foxglove_client(view.port) as client:
        assert client.info["capabilities"] == []
        await client.send(**asked)
        while not client.statuses:
            await client.take()
    (refused,) = client.statuses
    assert (refused["op"], refused["level"]) == ("status", 2)
    assert "does not support" in refused["message"]


async def test_a_service_cannot_be_called(view: FoxgloveView) -> None:
    async with foxglove_client(view.port) as client:
        await client.socket.send(b"\x02" + bytes(12))
        while not client.statuses:
            await client.take()
    assert client.statuses[0]["op"] == "serviceCallFailure"


async def test_nonsense_and_half_an_opening_harm_nobody(view: FoxgloveView) -> None:
    with pytest.raises(InvalidStatus):
        await connect(f"ws://127.0.0.1:{view.port}", proxy=None).__aenter__()
    with socket.create_connection(("127.0.0.1", view.port)) as half:
        half.sendall(b"GET / HTTP/1.1\r\nUpgrade: webso")
        async with foxglove_client(view.port) as client:
            await client.socket.send("{")
            await client.socket.send(b"\xff" * 100)
            view.show(scan(1))
            await client.advertised("/scan")


async def test_nobody_who_does_not_answer_holds_up_the_end() -> None:
    view = open_foxglove(0)
    port = view.port
    with socket.create_connection(("127.0.0.1", port)) as half:
        half.sendall(b"GET / HTTP/1.1\r\nUpgrade: webso")
        async with foxglove_client(view.port) as stalled:
            view.show(scan(0))
            await stalled.advertised("/scan")
            await stalled.subscribe("/scan")
            await stalled.next_of("/scan")
            for number in range(1, 101):  # 20 MB, more than its socket takes
                view.show(scan(number, size=200_000))
            closing = threading.Thread(target=view.close, daemon=True)  # a close without an end fails, and hangs not
            closing.start()
            closing.join(5.0 * CLOSE_S_MAX)  # nor does this client read meanwhile: it needs the loop
            stalled.socket.transport.abort()
        assert not closing.is_alive()
        with pytest.raises(ConnectionRefusedError):
            socket.create_connection(("127.0.0.1", port))


async def test_a_client_that_does_not_read_keeps_nothing_from_another(view: FoxgloveView) -> None:
    view.show(scan(0))
    async with foxglove_client(view.port) as stalled, foxglove_client(view.port) as reading:
        for client in (stalled, reading):
            await client.advertised("/scan")
            await client.subscribe("/scan")
        await reading.next_of("/scan")
        for number in range(1, 301):
            view.show(scan(number, size=200_000))  # 60 MB, more than its socket and its backlog take
            while (await reading.next_of("/scan"))[:8] != number.to_bytes(8):
                pass


def test_of_one_topic_the_newest_wait_and_of_another_nothing_is_lost() -> None:
    view = FoxgloveView()  # not opened: nobody takes anything out
    fixed = Raw("/tf_static", SCAN, 0, b"fixed")
    view.show(fixed)
    for number in range(10 * WAITING_MAX):
        view.show(scan(number))
    assert [each.log_ns for each in view.waiting("/scan")] == list(range(9 * WAITING_MAX, 10 * WAITING_MAX))
    assert view.waiting("/tf_static") == (fixed,)


def test_of_pictures_only_a_few_wait_and_always_the_newest() -> None:
    view = FoxgloveView()  # not opened: nobody takes anything out
    for number in range(20):
        view.show(scan(number, size=WAITING_BYTES_MAX // 4))
    assert [each.log_ns for each in view.waiting("/scan")] == [16, 17, 18, 19]
    view.show(scan(20, size=2 * WAITING_BYTES_MAX))
    assert [each.log_ns for each in view.waiting("/scan")] == [20]


async def test_clients_that_do_not_read_cost_some_pictures_each(view: FoxgloveView) -> None:
    view.show(scan(0))
    async with foxglove_client(view.port) as one, foxglove_client(view.port) as other:
        for client in (one, other):
            await client.advertised("/scan")
            await client.subscribe("/scan")
            await client.next_of("/scan")
            client.socket.transport.pause_reading()  # pyright: ignore[reportAttributeAccessIssue]
        before = rss_bytes()
        for number in range(250):
            view.show(scan(number, size=PICTURE_BYTES))
            await until(lambda: not view.waiting("/scan"))
        assert rss_bytes() - before < 2 * 2 * BACKLOG_MAX * PICTURE_BYTES
        one.socket.transport.abort()
        other.socket.transport.abort()
    assert BACKLOG_MAX * PICTURE_BYTES < 30e6


async def test_a_client_hears_of_every_new_topic_and_is_told_the_newest_of_each(view: FoxgloveView) -> None:
    topics = [each.channel.name for each in ros_topics(RosSettings(), 1.0)] + [each.name for each in ALL_TOPICS]
    assert len(topics) < BACKLOG_MAX
    async with foxglove_client(view.port) as client:
        for topic in topics:
            view.show(Raw(topic, SCAN, 0, bytes(2000)))
        await client.advertised(*topics)
        await client.subscribe(*topics)
        async with asyncio.timeout(30.0):
            while {topic for topic, _, _ in client.heard} != set(topics):
                await client.take()


async def test_without_a_port_nobody_listens_and_one_that_is_taken_costs_the_view_only(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        settings = Settings(state_dir=tmp_path, foxglove_port=taken.getsockname()[1])
        app = create_app(settings, bus=MemoryBus(), robot=FakeRobot(ToyRobot()))
        with capture_logs() as said:
            async with LifespanManager(app):
                pass
    assert [each["event"] for each in said if each["log_level"] == "error"] == ["no live view"]
    assert Settings(state_dir=tmp_path).foxglove_port is None


def test_it_listens_on_this_machine_only(view: FoxgloveView) -> None:
    listening = Path("/proc/net/tcp").read_text(encoding="ascii").splitlines()[1:]
    addresses = {line.split()[1] for line in listening if line.split()[1].endswith(f":{view.port:04X}")}
    assert {each.partition(":")[0] for each in addresses} == {"0100007F"}
    assert f":{view.port:04X}" not in Path("/proc/net/tcp6").read_text(encoding="ascii")
