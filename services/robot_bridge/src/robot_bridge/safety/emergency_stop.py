"""The software stop that latches: pure transitions, and a file that outlives the process."""

import os
import threading
from collections import deque
from pathlib import Path

from pydantic import ValidationError

from contracts.robot import EmergencyStop, EmergencyStopEvent

HISTORY_MAX = 200


def stopped(state: EmergencyStop, *, reason: str, by: str, now_s: float) -> EmergencyStop:
    """Latched, one epoch on. A second stop keeps the first one's time, and tells the newest reason."""
    since_s = state.since_s if state.latched and state.since_s is not None else now_s
    return EmergencyStop(latched=True, epoch=state.epoch + 1, reason=reason, by=by, since_s=since_s)


def halted(state: EmergencyStop) -> EmergencyStop:
    """One epoch on, so that what was asked for before is refused; latched only where it was."""
    return state.model_copy(update={"epoch": state.epoch + 1})


def reset(state: EmergencyStop, *, reason: str, by: str) -> EmergencyStop:
    """Motion is permitted again, never resumed: the epoch stays, and everything asked for before it is gone."""
    return EmergencyStop(latched=False, epoch=state.epoch, reason=reason, by=by)


class LatchFile:
    """The latch on disk. Replaced atomically; what cannot be read counts as latched."""

    def __init__(self, directory: Path) -> None:
        self._path = directory / "emergency_stop.json"

    def load(self, *, now_s: float) -> EmergencyStop:
        """The stored state; a fresh one where there never was a file; a latched one where the file is unreadable.

        A lost epoch is replaced by the time in seconds, which is beyond any that was counted up to from there.
        """
        try:
            return EmergencyStop.model_validate_json(self._path.read_bytes())
        except FileNotFoundError:
            return EmergencyStop(latched=False, epoch=0)
        except (ValidationError, OSError) as error:
            return EmergencyStop(
                latched=True,
                epoch=int(now_s),
                reason=f"the stored state cannot be read ({type(error).__name__})",
                by="robot_bridge",
                since_s=now_s,
            )

    def store(self, state: EmergencyStop) -> None:
        """Survives the death of the process at once (and of the machine after `sync`). Raises `OSError`."""
        self._path.parent.mkdir(parents=True, exist_ok=True)
        beside = self._path.with_suffix(f".{os.getpid()}.tmp")
        beside.write_bytes(state.model_dump_json().encode())
        beside.replace(self._path)

    def sync(self) -> None:
        """Waits until the disk has it; slow, so never in the way of a stop."""
        for path in (self._path, self._path.parent):
            handle = os.open(path, os.O_RDONLY)
            try:
                os.fsync(handle)
            finally:
                os.close(handle)


class StopHistory:
    """Who stopped and reset the robot, when and why: the newest 200, on disk one JSON object a line, oldest first."""

    def __init__(self, directory: Path) -> None:
        """Lines that cannot be read are left out: a torn file hinders nothing."""
        self._path = directory / "emergency_stop_history.jsonl"
        self._events: deque[EmergencyStopEvent] = deque(maxlen=HISTORY_MAX)
        self._writing = threading.Lock()
        try:
            lines = self._path.read_bytes().splitlines()
        except OSError:
            lines = []
        for line in lines[-HISTORY_MAX:]:
            try:
                self._events.append(EmergencyStopEvent.model_validate_json(line))
            except ValidationError:
                continue

    def add(self, event: EmergencyStopEvent) -> None:
        """In memory; `store` writes it."""
        self._events.append(event)

    def newest(self, limit: int) -> list[EmergencyStopEvent]:
        """Newest first."""
        return list(reversed(self._events))[:limit]

    def store(self) -> None:
        """Replaces the file; slow, so in a thread. Raises `OSError`."""
        with self._writing:
            lines = [event.model_dump_json() for event in tuple(self._events)]
            self._path.parent.mkdir(parents=True, exist_ok=True)
            beside = self._path.with_suffix(f".{os.getpid()}.tmp")
            beside.write_text("".join(f"{line}\n" for line in lines))
            beside.replace(self._path)
