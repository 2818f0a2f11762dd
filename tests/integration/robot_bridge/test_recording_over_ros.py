"""A recording of real ROS 2 topics, read back with the MCAP library and its ROS 2 decoder."""

import io
from typing import Any

import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from contracts.recording import Recording
from support.bridge_behaviour import INSIDE, Rig
from support.waiting import until_true

pytestmark = pytest.mark.filterwarnings("ignore:failed to send response:RuntimeWarning")

WANTED = {
    "/scan": "sensor_msgs/msg/LaserScan",
    "/odom": "nav_msgs/msg/Odometry",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/map": "nav_msgs/msg/OccupancyGrid",
    "/plan": "nav_msgs/msg/Path",
    "/rosout": "rcl_interfaces/msg/Log",
    "/battery_state": "sensor_msgs/msg/BatteryState",
    "/dock_status": "irobot_create_msgs/msg/DockStatus",
    "/hazard_detection": "irobot_create_msgs/msg/HazardDetectionVector",
    "/wheel_status": "irobot_create_msgs/msg/WheelStatus",
    "/cmd_vel": "geometry_msgs/msg/TwistStamped",
    "/oakd/rgb/preview/image_raw": "sensor_msgs/msg/Image",
    "/oakd/rgb/preview/camera_info": "sensor_msgs/msg/CameraInfo",
    "/oakd/stereo/image_raw": "sensor_msgs/msg/Image",
}


async def test_every_topic_of_the_robot_is_recorded_with_the_definition_that_reads_it(rig: Rig) -> None:
    rig.toy.hazards.add("BUMP")
    recording_id = (await rig.post("/recordings", {"images": True})).json()["id"]

    async def heard() -> bool:
        await rig.post("/navigation/path", {"goal": INSIDE})
        told = Recording.model_validate_json((await rig.client.get(f"/recordings/{recording_id}")).content)
        return {*WANTED, "robot.state"} <= told.topics.keys()

    await until_true(heard, timeout_s=40.0)
    assert (await rig.post(f"/recordings/{recording_id}/stop")).json()["reason"] == "stopped"
    file = await rig.client.get(f"/recordings/{recording_id}/file")
    reader = make_reader(io.BytesIO(file.content), decoder_factories=[DecoderFactory()])
    newest: dict[str, Any] = {}
    for schema, channel, message in reader.iter_messages(topics=list(WANTED)):
        assert schema is not None
        assert (schema.name, schema.encoding) == (WANTED[channel.topic], "ros2msg")
        newest[channel.topic] = (schema, channel, message)
    assert newest.keys() == WANTED.keys()
    decoded = {topic: _decoded(*found) for topic, found in newest.items()}
    assert len(decoded["/scan"].ranges) == 144
    assert decoded["/odom"].child_frame_id == "base_link"
    assert {each.child_frame_id for each in decoded["/tf_static"].transforms} == {"laser", "optical"}
    assert (decoded["/map"].info.width, decoded["/map"].info.height) == (80, 60)
    assert decoded["/plan"].poses[-1].pose.position.x == INSIDE["x"]
    assert decoded["/rosout"].msg == "the toy is awake"
    assert decoded["/hazard_detection"].detections[0].type == 1
    picture = decoded["/oakd/rgb/preview/image_raw"]
    assert (picture.encoding, len(picture.data)) == ("rgb8", 250 * 250 * 3)


def _decoded(schema: Any, channel: Any, message: Any) -> Any:
    decode = DecoderFactory().decoder_for(channel.message_encoding, schema)
    assert decode is not None
    return decode(message.data)
