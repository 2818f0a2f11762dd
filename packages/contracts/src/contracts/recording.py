"""Recordings of a mission's topics, as MCAP files that Foxglove opens."""

from enum import StrEnum

from pydantic import Field

from contracts.base import Message, StampS


class RecordingState(StrEnum):
    RECORDING = "recording"
    """Being written; it cannot be downloaded yet."""
    FINISHED = "finished"
    """Closed and complete."""
    CUT_OFF = "cut_off"
    """The bridge ended while it was written; `mcap recover` mends it."""
    EMPTY = "empty"
    """Cut off before anything was kept: there is no file to fetch."""


class RecordingRequest(Message):
    name: str = Field(default="mission", pattern=r"^[A-Za-z0-9_.-]{1,40}$", description="becomes part of the file name")
    images: bool = Field(
        default=False, description="with the camera's pictures, at the setting's rate; they may show people"
    )
    seconds_max: float | None = Field(default=None, gt=0.0, le=86_400.0, description="none = the setting's limit")


class Recording(Message):
    """One file: ROS topics as CDR with their message definitions, the mesh's topics as JSON with their schemas."""

    id: str
    name: str
    state: RecordingState
    started_s: StampS
    ended_s: float | None = None
    size_bytes: int = Field(default=0, ge=0)
    messages: int = Field(default=0, ge=0)
    dropped: int = Field(default=0, ge=0, description="messages that came faster than the disk took them")
    topics: dict[str, int] = Field(default_factory=dict, description="messages written, by topic")
    reason: str = Field(default="", description="why it ended: stopped, size limit, time limit, ...")
