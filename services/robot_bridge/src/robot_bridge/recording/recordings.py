"""Recordings of a mission's topics: one at a time, bounded in size, in time and in what all of them may take."""

import asyncio
import contextlib
import time
import uuid
from pathlib import Path
from typing import Any

import structlog
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from contracts.recording import Recording, RecordingRequest, RecordingState
from mesh.bus import Bus
from mesh.clock import Clock
from mesh.errors import ConflictError, NotFoundError, UnavailableError
from mesh.tasks import Tasks
from robot_bridge.ports import Robot
from robot_bridge.recording.feed import Feed
from robot_bridge.recording.mcap_file import McapFile

log = structlog.get_logger()

RECORDINGS_MAX = 200
"""Kept; the oldest make room."""
UNFINISHED = {
    RecordingState.CUT_OFF: "cut off: the bridge ended while it was written; `mcap recover` mends it",
    RecordingState.EMPTY: "cut off: the bridge ended before anything was on the disk; nothing was kept",
}


class RecordingLimits(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")

    recording_bytes_max: int = Field(default=1_000_000_000, ge=10_000, description="of one recording")
    recordings_bytes_max: int = Field(default=5_000_000_000, ge=10_000, description="of all; the oldest make room")
    recording_s_max: float = Field(default=3600.0, gt=0.0, le=86_400.0, description="of one recording")
    recording_images_hz: float = Field(default=2.0, gt=0.0, le=30.0, description="of pictures, where they are wanted")


class _Running:
    """A recording under way and what feeds it."""

    def __init__(self, recording: Recording, file: McapFile, until_s: float, feed: Feed) -> None:
        self.recording = recording
        self.file = file
        self.until_s = until_s
        self.feed = feed

    def told(self, **changes: Any) -> Recording:
        counts = self.file.counts
        return self.recording.model_copy(
            update={
                "size_bytes": self.file.size_bytes,
                "messages": sum(counts.values()),
                "topics": counts,
                "dropped": self.file.dropped,
            }
            | changes
        )


class Recordings:
    """Files lie in `folder`, each beside a JSON file that tells what it holds."""

    def __init__(
        self, *, robot: Robot, bus: Bus, clock: Clock, tasks: Tasks, folder: Path, limits: RecordingLimits
    ) -> None:
        self._robot = robot
        self._bus = bus
        self._clock = clock
        self._tasks = tasks
        self._limits = limits
        self._folder = folder
        self._running: _Running | None = None
        self._changing = asyncio.Lock()

    async def start(self, request: RecordingRequest) -> Recording:
        """Raises `ConflictError` while one is under way, `UnavailableError` where the disk refuses."""
        async with self._changing:
            if self._running is not None:
                raise ConflictError(f"recording {self._running.recording.id} is under way")
            now_s = self._clock.now_s()
            recording = Recording(
                id=f"{time.strftime('%Y%m%dT%H%M%S', time.gmtime(now_s))}-{request.name}-{uuid.uuid4().hex[:6]}",
                name=request.name,
                state=RecordingState.RECORDING,
                started_s=now_s,
            )
            try:
                file = await asyncio.to_thread(self._open, recording.id)
            except OSError as error:
                raise UnavailableError("disk", error.strerror or str(error)) from error
            seconds = min(request.seconds_max or self._limits.recording_s_max, self._limits.recording_s_max)
            feed = Feed(
                "record",
                robot=self._robot,
                bus=self._bus,
                clock=self._clock,
                tasks=self._tasks,
                sink=file.put,
                images_hz=self._limits.recording_images_hz * request.images,
            )
            running = self._running = _Running(recording, file, now_s + seconds, feed)
            self._tasks.start("recording", self._watch(running), forever=False)
            return recording

    async def stop(self, recording_id: str) -> Recording:
        """Closes the file. A recording that has ended stays as it ended."""
        running = self._running
        if running is None or running.recording.id != recording_id:
            return await self.get(recording_id)
        return await self._end(running, "stopped")

    async def close(self) -> None:
        """Before the bridge ends: a file that is cut off is hard to read."""
        if self._running is not None:
            await self._end(self._running, "robot_bridge is shutting down")

    async def all(self) -> list[Recording]:
        """Newest first."""
        running = self._running  # one that ends meanwhile is told of as it was, not left out
        now = [running.told()] if running is not None else []
        return now + await asyncio.to_thread(self._finished, *(each.id for each in now))

    async def get(self, recording_id: str) -> Recording:
        for each in await self.all():
            if each.id == recording_id:
                return each
        raise NotFoundError(f"no recording {recording_id[:100]}")

    async def file(self, recording_id: str) -> Path:
        """The file of one that is no longer written, cut off or whole."""
        ended = await self._ended(recording_id)
        if ended.state is RecordingState.EMPTY:
            raise NotFoundError(ended.reason)
        return self._path(recording_id)

    async def delete(self, recording_id: str) -> None:
        await self._ended(recording_id)
        await asyncio.to_thread(self._remove, recording_id)

    async def _ended(self, recording_id: str) -> Recording:
        found = await self.get(recording_id)
        if found.state is RecordingState.RECORDING:
            raise ConflictError("it is still being written; stop it first")
        return found

    async def _watch(self, running: _Running) -> None:
        """Until somebody stops it, or a limit does."""
        while self._running is running:
            if running.file.ended:
                await self._end(running, running.file.ended_by)
            elif self._clock.now_s() > running.until_s:
                await self._end(running, "time limit")
            else:
                await self._clock.sleep(0.2)

    async def _end(self, running: _Running, reason: str) -> Recording:
        async with self._changing:
            if self._running is running:
                running.feed.close()
                await asyncio.to_thread(running.file.finish, reason)
                ended = running.told(
                    state=RecordingState.FINISHED, ended_s=self._clock.now_s(), reason=running.file.ended_by
                )
                await asyncio.to_thread(self._note, ended)
                self._running = None
                log.info("recorded", id=ended.id, messages=ended.messages, bytes=ended.size_bytes, why=ended.reason)
        return await self.get(running.recording.id)

    def _open(self, recording_id: str) -> McapFile:
        self._folder.mkdir(parents=True, exist_ok=True)
        self._make_room()
        return McapFile(self._path(recording_id), bytes_max=self._limits.recording_bytes_max)

    def _make_room(self) -> None:
        """The oldest go, so that one more of full size fits into what all may take, in bytes and in number."""
        room = self._limits.recordings_bytes_max - self._limits.recording_bytes_max
        for before, path in enumerate(self._newest_first()):
            room -= path.stat().st_size
            if room < 0 or before >= RECORDINGS_MAX - 1:
                log.warning("an old recording makes room", id=path.stem)
                self._remove(path.stem)

    def _finished(self, running_id: str = "") -> list[Recording]:
        found: list[Recording] = []
        for path in self._newest_first():
            if path.stem != running_id:
                with contextlib.suppress(FileNotFoundError):  # deleted meanwhile
                    found.append(self._told(path))
        return found

    def _newest_first(self) -> list[Path]:
        """By their names, which begin with the time."""
        return sorted(self._folder.glob("*.mcap"), key=lambda path: path.name, reverse=True)

    def _told(self, path: Path) -> Recording:
        with contextlib.suppress(OSError, ValidationError):
            return Recording.model_validate_json(path.with_suffix(".json").read_text())
        file = path.stat()
        changed_s = file.st_mtime
        state = RecordingState.CUT_OFF if file.st_size else RecordingState.EMPTY
        return Recording(
            id=path.stem,
            name=path.stem.split("-")[1] if path.stem.count("-") > 1 else path.stem,
            state=state,
            started_s=changed_s,
            ended_s=changed_s,
            size_bytes=file.st_size,
            reason=UNFINISHED[state],
        )

    def _note(self, recording: Recording) -> None:
        try:
            self._path(recording.id).with_suffix(".json").write_text(recording.model_dump_json())
        except OSError as error:
            log.warning("what a recording holds could not be noted", id=recording.id, error=str(error))

    def _remove(self, recording_id: str) -> None:
        path = self._path(recording_id)
        for each in (path, path.with_suffix(".json")):
            each.unlink(missing_ok=True)

    def _path(self, recording_id: str) -> Path:
        return self._folder / f"{recording_id}.mcap"
