"""docs/foxglove/atom-layout.json: every topic it shows is recorded, with a schema that its panel draws."""

import dataclasses
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import pytest
from foxglove import layouts
from pydantic import BaseModel

from contracts.topics import ALL_TOPICS
from robot_bridge.recording.ros_topics import ros_topics
from robot_bridge.settings import RosSettings

LAYOUT: Final[dict[str, Any]] = json.loads(Path("docs/foxglove/atom-layout.json").read_text(encoding="utf-8"))
PANELS: Final[dict[str, dict[str, Any]]] = LAYOUT["configById"]
JSON: Final = {topic.name: topic.message for topic in ALL_TOPICS}
RECORDED: Final = {f"/{each.channel.name.lstrip('/')}": each.type_name for each in ros_topics(RosSettings(), 1.0)}
PATH: Final = re.compile(r'^(?:"([^"]+)"|(/[\w/]+))((?:\.\w+)*)$')
"""Foxglove's message path: a topic, in quotes where its name has a dot, and fields."""

DRAWN: Final = {
    "3D": {
        "geometry_msgs/msg/PoseWithCovarianceStamped",
        "nav_msgs/msg/OccupancyGrid",
        "nav_msgs/msg/Path",
        "sensor_msgs/msg/CameraInfo",
        "sensor_msgs/msg/LaserScan",
    },
    "Image": {"sensor_msgs/msg/CameraInfo", "sensor_msgs/msg/CompressedImage", "sensor_msgs/msg/Image"},
    "RosOut": {"rcl_interfaces/msg/Log"},
}
"""What panels draw, of what is here, as Foxglove's documentation lists it (docs.foxglove.dev, visualization/panels).
The others read the fields of any message."""

CONFIGS: Final = {
    "3D": layouts.ThreeDeeConfig,
    "Image": layouts.ImageConfig,
    "Plot": layouts.PlotConfig,
    "RawMessages": layouts.RawMessagesConfig,
    "RosOut": layouts.LogConfig,
    "StateTransitions": layouts.StateTransitionsConfig,
}


def kind(panel_id: str) -> str:
    return panel_id.partition("!")[0]


def paths() -> list[str]:
    """Message paths of the panels that read fields."""
    rows = [each["value"] for config in PANELS.values() for each in config.get("paths", ())]
    return [*rows, *(config["topicPath"] for config in PANELS.values() if "topicPath" in config)]


def drawn() -> list[tuple[str, str]]:
    """Each panel that draws whole messages, with each topic of its own."""
    found = [(name, topic) for name, config in PANELS.items() for topic in config.get("topics", {})]
    for name, config in PANELS.items():
        images = config.get("imageMode", {})
        found += [(name, images[key]) for key in ("imageTopic", "calibrationTopic") if key in images]
        found += [(name, config["topicToRender"])] if "topicToRender" in config else []
    return found


def leaves(tree: Any) -> Iterator[str]:
    if isinstance(tree, str):
        yield tree
    else:
        yield from leaves(tree["first"])
        yield from leaves(tree["second"])


@pytest.mark.parametrize(("panel", "topic"), drawn())
def test_a_panel_shows_a_recorded_topic_of_a_schema_that_it_draws(panel: str, topic: str) -> None:
    assert RECORDED[topic] in DRAWN[kind(panel)]


@pytest.mark.parametrize("path", paths())
def test_a_message_path_begins_with_a_recorded_topic_and_leads_to_a_field(path: str) -> None:
    found = PATH.match(path)
    assert found is not None
    quoted, ros, fields = found.groups()
    assert ros in RECORDED if ros else quoted in JSON
    message: Any = JSON[quoted] if quoted else None
    for name in fields.split(".")[1:] if quoted else ():
        assert issubclass(message, BaseModel)
        message = message.model_fields[name].annotation


def test_every_panel_has_its_place() -> None:
    assert sorted(leaves(LAYOUT["layout"])) == sorted(PANELS)


@pytest.mark.parametrize("panel", PANELS)
def test_a_panel_is_told_what_it_can_be_told(panel: str) -> None:
    """As the SDK describes each panel's settings."""
    known = {re.sub(r"_(\w)", lambda m: m[1].upper(), field.name) for field in dataclasses.fields(CONFIGS[kind(panel)])}
    assert PANELS[panel].keys() - {"foxglovePanelTitle"} <= known


def test_map_path_scan_camera_velocity_and_log_are_to_be_seen() -> None:
    shown = {topic for _, topic in drawn()} | {path.partition(".")[0] for path in paths()}
    assert {"/map", "/plan", "/scan", "/cmd_vel", "/odom", "/rosout", "/oakd/rgb/preview/image_raw"} <= shown
