"""One picture for everybody: many viewers cost one encoding of each frame."""

import asyncio
import contextlib

import pytest

from mesh.latest_value import LatestValue
from robot_bridge.sensing.camera import Camera
from robot_bridge.sensing.sensor_readings import ColourImage
from robot_bridge.sensing.stamps import Clocks
from support.toy_robot import ToyRobot
from support.waiting import until

VIEWERS = 8
FRAMES = 5


def frame(stamp_s: float) -> ColourImage:
    return ColourImage(stamp_s, "optical", ToyRobot().picture())


async def test_eight_viewers_and_as_many_pollers_share_one_encoding_of_each_frame() -> None:
    frames: LatestValue[ColourImage] = LatestValue()
    camera = Camera(frames, jpeg_quality=85)
    seen: list[list[bytes]] = [[] for _ in range(VIEWERS)]

    async def watch(parts: list[bytes]) -> None:
        async with contextlib.aclosing(camera.stream()) as stream:
            async for part in stream:
                parts.append(part)
                if len(parts) == FRAMES:
                    return

    viewers = [asyncio.create_task(watch(parts)) for parts in seen]
    for number in range(1, FRAMES + 1):
        await until(lambda: camera.viewers == VIEWERS, timeout_s=30.0)
        stamp_s = float(number)
        frames.put(frame(stamp_s), stamp_s)
        polled = await asyncio.gather(*(camera.picture(after_s=stamp_s - 0.5, wait_s=30.0) for _ in range(VIEWERS)))
        assert {picture.stamp_s for picture in polled if picture is not None} == {stamp_s}
        await until(lambda number=number: all(len(parts) == number for parts in seen), timeout_s=30.0)
    await asyncio.gather(*viewers)
    assert camera.encoded == FRAMES
    assert camera.viewers == 0
    assert all(parts == seen[0] for parts in seen)


async def test_a_viewer_who_comes_late_or_is_slow_sees_the_newest_frame_and_none_twice() -> None:
    frames: LatestValue[ColourImage] = LatestValue()
    camera = Camera(frames, jpeg_quality=85)
    async with contextlib.aclosing(camera.stream()) as stream:
        for stamp_s in (1.0, 2.0, 3.0):
            frames.put(frame(stamp_s), stamp_s)
        assert b"X-Stamp-S: 3.000000" in await anext(stream)
        for stamp_s in (4.0, 5.0):
            frames.put(frame(stamp_s), stamp_s)
        assert b"X-Stamp-S: 5.000000" in await anext(stream)
    assert camera.encoded == 2


async def test_the_stream_goes_on_whatever_the_stamps_do() -> None:
    """What came later is newer."""
    frames: LatestValue[ColourImage] = LatestValue()
    camera = Camera(frames, jpeg_quality=85)
    async with contextlib.aclosing(camera.stream()) as stream:
        for number, stamp_s in enumerate((100.0, 99.9, 5.0, 5.0, 1e9)):
            frames.put(frame(stamp_s), float(number))
            part = await asyncio.wait_for(anext(stream), 30.0)
            assert f"X-Stamp-S: {stamp_s:.6f}".encode() in part


@pytest.mark.parametrize(
    "off_s", [None, 0.0, 3600.0, -3600.0, 1.6e9], ids=["no stamps", "right", "behind", "ahead", "since boot"]
)
async def test_each_picture_is_newer_than_the_last_whatever_clock_stamped_it(off_s: float | None) -> None:
    """As `GET /camera/frame?after=` and the page's puller ask: after the last one's stamp."""
    clocks = Clocks()
    frames: LatestValue[ColourImage] = LatestValue()
    camera = Camera(frames, jpeg_quality=85)
    last_s: float | None = None
    for number in range(6):
        now_s = 1_700_000_000.0 + number * 0.1
        moment = clocks.moment("rgb", 0.0 if off_s is None else now_s - off_s, now_s)
        assert moment is not None
        frames.put(frame(moment.stamp_s), now_s)
        picture = await camera.picture(after_s=last_s, wait_s=0.0)
        assert picture is not None
        last_s = picture.stamp_s
