"""What a recording never holds, never exceeds, and survives."""

import contextlib
import io
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mcap.exceptions import EndOfFile
from mcap.reader import make_reader
from mcap.records import Message as McapMessage
from mcap.stream_reader import StreamReader

from contracts.recording import Recording, RecordingState
from contracts.topics import VISION_DETECTIONS
from contracts.vision import Detection, Detections
from robot_bridge.ports import Raw, Sink
from robot_bridge.recording.mcap_file import WAITING_MAX, McapFile, json_kind
from robot_bridge.recording.recordings import RECORDINGS_MAX
from support.bridge_behaviour import Rig, running
from support.fake_robot import FakeRobot
from support.toy_robot import ToyRobot
from support.waiting import until, until_true

KIND = json_kind(Recording)


def raw(size: int = 10_000, topic: str = "noise") -> Raw:
    data = bytes(time.perf_counter_ns() % 251 for _ in range(100)) * (size // 100)
    return Raw(topic, KIND, time.time_ns(), data)


async def of(rig: Rig, recording_id: str) -> Recording:
    return Recording.model_validate_json((await rig.client.get(f"/recordings/{recording_id}")).content)


async def test_people_are_not_recorded(rig: Rig) -> None:
    recording_id = (await rig.post("/recordings")).json()["id"]
    await until(lambda: rig.bus.listened_to(VISION_DETECTIONS))
    seen = tuple(
        Detection(label=label, confidence=0.9, bbox_xyxy=(0.0, 0.0, 9.0, 9.0)) for label in ("person", "bottle")
    )
    message = Detections(stamp_s=1.0, image_width_px=250, image_height_px=250, detections=seen)
    await rig.bus.publish(VISION_DETECTIONS, message)

    async def written() -> bool:
        return "vision.detections" in (await of(rig, recording_id)).topics

    await until_true(written)
    await rig.post(f"/recordings/{recording_id}/stop")
    file = await rig.client.get(f"/recordings/{recording_id}/file")
    (found,) = [
        message.data
        for _, channel, message in make_reader(io.BytesIO(file.content)).iter_messages()
        if channel.topic == "vision.detections"
    ]
    assert [each.label for each in Detections.model_validate_json(found).detections] == ["bottle"]


async def limited(tmp_path: Path, **settings: Any) -> Recording:
    """A recording that ends by itself, with these limits."""
    toy = ToyRobot()
    async with running(tmp_path, toy, FakeRobot(toy), **settings) as rig:
        recording_id = (await rig.post("/recordings")).json()["id"]

        async def over() -> bool:
            return (await of(rig, recording_id)).ended_s is not None

        await until_true(over, timeout_s=40.0)
        return await of(rig, recording_id)


async def test_a_recording_ends_at_its_time_limit(tmp_path: Path) -> None:
    assert (await limited(tmp_path, recording_s_max=0.5)).reason == "time limit"


async def test_a_recording_ends_at_its_size_limit(tmp_path: Path) -> None:
    ended = await limited(tmp_path, recording_bytes_max=60_000)
    assert ended.reason == "size limit"
    assert ended.size_bytes < 100_000


def test_a_file_never_grows_past_its_limit_by_more_than_a_chunk_and_stays_readable(tmp_path: Path) -> None:
    file = McapFile(tmp_path / "a.mcap", bytes_max=500_000)
    while not file.ended:
        file.put(raw())
    file.finish("stopped")
    assert file.ended_by == "size limit"
    assert file.path.stat().st_size < 900_000
    with file.path.open("rb") as stream:
        assert len(list(make_reader(stream).iter_messages())) == sum(file.counts.values())


async def test_what_was_said_a_second_ago_is_in_the_file_of_a_bridge_that_is_killed(tmp_path: Path) -> None:
    file = McapFile(tmp_path / "a.mcap", bytes_max=10_000_000)
    for _ in range(50):
        file.put(raw(100))
    await until(lambda: file.path.stat().st_size > 0)
    killed = file.path.read_bytes()
    file.finish("stopped")
    readable: list[McapMessage] = []
    with contextlib.suppress(EndOfFile):
        readable.extend(each for each in StreamReader(io.BytesIO(killed)).records if isinstance(each, McapMessage))
    assert len(readable) == 50


async def test_a_recording_of_which_nothing_was_kept_says_so(tmp_path: Path) -> None:
    toy = ToyRobot()
    folder = tmp_path / "recordings"
    folder.mkdir()
    for name, held in (("20260101T000000-cut-abcdef", b" " * 100), ("20260102T000000-lost-abcdef", b"")):
        (folder / f"{name}.mcap").write_bytes(held)
    async with running(tmp_path, toy, FakeRobot(toy)) as rig:
        lost, cut = [Recording.model_validate(each) for each in (await rig.client.get("/recordings")).json()]
        assert (cut.state, lost.state) == (RecordingState.CUT_OFF, RecordingState.EMPTY)
        assert ("mcap recover" in cut.reason, lost.reason.endswith("nothing was kept")) == (True, True)
        files = [(await rig.client.get(f"/recordings/{each.id}/file")).status_code for each in (lost, cut)]
        assert files == [404, 200]
        assert (await rig.client.delete(f"/recordings/{lost.id}")).status_code == 204
        assert [each["id"] for each in (await rig.client.get("/recordings")).json()] == [cut.id]


def test_a_disk_that_refuses_ends_the_recording_and_nothing_else(tmp_path: Path) -> None:
    full = Path("/dev/full")
    file = McapFile(full, bytes_max=10_000_000)
    while not file.ended:
        file.put(raw(100_000))
    file.finish("stopped")
    assert file.ended_by == "it could not be written: No space left on device"


def test_a_full_queue_behind_a_writer_that_has_ended_holds_nobody_up(tmp_path: Path) -> None:
    file = McapFile(tmp_path / "a.mcap", bytes_max=10_000)
    while not file.ended:
        file.put(raw(100_000))
    file._ended.clear()  # as between its last look at the queue and the end of the file
    for _ in range(WAITING_MAX + 1):
        file.put(raw(100))
    assert file.dropped > 0
    file.finish("stopped")
    assert file.ended_by == "size limit"


async def test_so_many_recordings_are_kept_and_the_oldest_of_them_can_be_fetched(tmp_path: Path) -> None:
    toy = ToyRobot()
    folder = tmp_path / "recordings"
    folder.mkdir()
    names = [f"20260101T{number:06d}-old-abcdef" for number in range(RECORDINGS_MAX + 5)]
    for name in names:
        (folder / f"{name}.mcap").write_bytes(b" ")
    async with running(tmp_path, toy, FakeRobot(toy)) as rig:
        await rig.post("/recordings")
        kept = [each["id"] for each in (await rig.client.get("/recordings")).json()]
        assert len(kept) == RECORDINGS_MAX
        assert kept[-1] == names[6]
        assert (await rig.client.get(f"/recordings/{names[6]}/file")).content == b" "
        assert (await rig.client.get(f"/recordings/{names[5]}/file")).status_code == 404


async def test_the_oldest_recordings_make_room(tmp_path: Path) -> None:
    toy = ToyRobot()
    folder = tmp_path / "recordings"
    folder.mkdir()
    for day in (1, 2, 3):
        (folder / f"2026010{day}T000000-old-abcdef.mcap").write_bytes(b" " * 40_000)
    limits = {"recording_bytes_max": 50_000, "recordings_bytes_max": 100_000}
    async with running(tmp_path, toy, FakeRobot(toy), **limits) as rig:
        listed = [Recording.model_validate(each) for each in (await rig.client.get("/recordings")).json()]
        assert [each.reason[:7] for each in listed] == ["cut off"] * 3
        await rig.post("/recordings")
        kept = [each["id"] for each in (await rig.client.get("/recordings")).json()]
        assert "20260103T000000-old-abcdef" in kept
        assert "20260101T000000-old-abcdef" not in kept


async def test_a_bridge_that_ends_closes_its_recording(tmp_path: Path) -> None:
    toy = ToyRobot()
    async with running(tmp_path, toy, FakeRobot(toy)) as rig:
        recording_id = (await rig.post("/recordings")).json()["id"]
        await until(lambda: len(rig.bus.published) > 5)
    with (tmp_path / "recordings" / f"{recording_id}.mcap").open("rb") as stream:
        assert make_reader(stream).get_summary() is not None


class Watched(FakeRobot):
    """Notes what the robot was last told when its recording is closed."""

    last_told: tuple[float, float] | None = None

    def record(self, sink: Sink, *, images_hz: float) -> Callable[[], None]:
        def close() -> None:
            self.last_told = self.toy.velocities[-1]

        return close


async def test_a_bridge_that_ends_stops_the_robot_before_it_closes_its_recording(tmp_path: Path) -> None:
    toy = ToyRobot()
    robot = Watched(toy)
    async with running(tmp_path, toy, robot) as rig:
        await rig.post("/recordings")
        await rig.velocity(duration_s=2.0)
        await until(lambda: toy.has_driven)
    assert robot.last_told == (0.0, 0.0)
