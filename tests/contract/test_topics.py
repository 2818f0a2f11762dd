"""The topics are one list, and their wire format is pinned."""

import pytest
from pydantic import ValidationError

from contracts.mission import MissionTarget
from contracts.robot import EmergencyStop
from contracts.topics import ALL_TOPICS, MISSION_TARGET, ROBOT_EMERGENCY_STOP, bus_rules, traceparent_of
from contracts.vision import Target

SERVICES = {"coordinator", "inference", "memory", "robot_bridge", "ui"}


def test_names_are_unique() -> None:
    assert len({topic.name for topic in ALL_TOPICS}) == len(ALL_TOPICS)


def test_every_topic_has_one_publisher_among_the_services() -> None:
    assert {topic.publisher for topic in ALL_TOPICS} <= SERVICES


def test_the_wire_format_is_pinned() -> None:
    target = b'{"label":"bottle","description":"red bottle","colour":"red","not_colours":[]}'
    wire = b'{"target":%s,"mission_id":"m1","fast":false}' % target
    message = MissionTarget(target=Target(label="bottle", description="red bottle"), mission_id="m1")
    assert MISSION_TARGET.encode(message) == wire
    assert MISSION_TARGET.decode(wire) == message


def test_the_trace_stands_before_the_message_and_may_be_missing() -> None:
    parent, message = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01", MissionTarget(mission_id="m1")
    plain = MISSION_TARGET.encode(message)
    traced = b'{"traceparent":"%s",%s' % (parent.encode(), plain[1:])
    assert MISSION_TARGET.encode(message, parent) == traced
    assert [MISSION_TARGET.decode(data) for data in (plain, traced)] == [message, message]
    assert [traceparent_of(data) for data in (plain, traced)] == ["", parent]


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"null",
        b'{"latched":true}',
        b'{"latched":true,"epoch":1,"extra":1}',
        b'{"traceparent":"no trace","latched":true,"epoch":1}',
    ],
)
def test_anything_else_is_refused(data: bytes) -> None:
    with pytest.raises(ValidationError):
        ROBOT_EMERGENCY_STOP.decode(data)


def test_messages_refuse_nan() -> None:
    with pytest.raises(ValidationError):
        EmergencyStop(latched=False, epoch=0, since_s=float("nan"))


def test_a_service_may_at_redis_what_the_topics_name_it_for() -> None:
    assert set(bus_rules("memory")) == {
        "~last:robot.description", "~last:robot.state", "&robot.description", "&robot.state", "&vision.detections",
        "+ping", "+hello", "+select", "+subscribe", "+unsubscribe", "+get",
    }  # fmt: skip
    assert "+publish" not in bus_rules("ui")
