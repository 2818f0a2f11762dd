"""Real ROS 2 topics in the live view, and that the shipped layout's paths lead to fields of theirs."""

import importlib
import json
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import pytest
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory

from robot_bridge.adapters.foxglove import FoxgloveView, open_foxglove
from robot_bridge.recording.ros_topics import ros_topics
from robot_bridge.settings import RosSettings
from support.bridge_behaviour import Rig, running
from support.foxglove_client import foxglove_client
from support.toy_robot import ToyRobot

pytestmark = pytest.mark.filterwarnings("ignore:failed to send response:RuntimeWarning")

SHOWN = ("/map", "/scan", "/odom", "/tf_static", "/cmd_vel", "/oakd/rgb/preview/image_raw")


@pytest.fixture
async def shown(tmp_path: Path, toy: ToyRobot) -> AsyncIterator[tuple[Rig, FoxgloveView]]:
    view = open_foxglove(0)
    async with running(tmp_path, toy, None, live_view=view) as rig:
        yield rig, view


async def test_the_robots_topics_are_shown_as_they_come_over_the_wire(shown: tuple[Rig, FoxgloveView]) -> None:
    rig, view = shown
    async with foxglove_client(view.port) as client:
        await client.advertised("robot.state", *SHOWN, timeout_s=60.0)
        types = {each.channel.name: each.type_name for each in ros_topics(rig.settings.ros, 1.0)}
        read: dict[str, Any] = {}
        for topic in SHOWN:
            channel = client.channels[topic]
            assert (channel["encoding"], channel["schemaEncoding"]) == ("cdr", "ros2msg")
            assert channel["schemaName"] == types[topic.removeprefix("/")]
            await client.subscribe(topic)
            schema = Schema(data=channel["schema"].encode(), encoding="ros2msg", id=1, name=channel["schemaName"])
            decode = DecoderFactory().decoder_for("cdr", schema)
            assert decode is not None
            read[topic] = decode(await client.next_of(topic))
    assert (read["/map"].info.width, read["/map"].info.height) == (80, 60)  # said once, before the client came
    assert {each.child_frame_id for each in read["/tf_static"].transforms} == {"laser", "optical"}
    assert len(read["/scan"].ranges) == 144
    assert read["/cmd_vel"].twist.linear.x == 0.0


def paths() -> list[str]:
    layout = json.loads(Path("docs/foxglove/atom-layout.json").read_text(encoding="utf-8"))
    rows = [each["value"] for config in layout["configById"].values() for each in config.get("paths", ())]
    return [row for row in rows if row.startswith("/")]


@pytest.mark.parametrize("path", paths())
def test_a_message_path_of_the_layout_leads_to_a_field(path: str) -> None:
    topic, *fields = path.split(".")
    types = {f"/{each.channel.name.lstrip('/')}": each.type_name for each in ros_topics(RosSettings(), 0.0)}
    package, _, name = types[topic].split("/")
    message = getattr(importlib.import_module(f"{package}.msg"), name)()
    for each in fields:
        message = getattr(message, each)
    assert isinstance(message, float)
