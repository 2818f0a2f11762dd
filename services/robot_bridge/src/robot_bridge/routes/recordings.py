"""Recordings: start, stop, list, fetch."""

from typing import Annotated

from fastapi import APIRouter, Path
from fastapi.responses import FileResponse

from contracts.recording import Recording, RecordingRequest
from mesh.access import Role, requires_role
from robot_bridge.routes.deps import BridgeDep

router = APIRouter(prefix="/recordings", tags=["recordings"])

RecordingId = Annotated[str, Path(min_length=1, max_length=100)]


@router.post("")
@requires_role(Role.OPERATOR)
async def start(request: RecordingRequest, bridge: BridgeDep) -> Recording:
    """Begins to write the robot's ROS topics and the mesh's own into one MCAP file; 409 while another is under way."""
    return await bridge.recordings.start(request)


@router.get("")
@requires_role(Role.VIEWER)
async def read_all(bridge: BridgeDep) -> list[Recording]:
    """Newest first."""
    return await bridge.recordings.all()


@router.get("/{recording_id}")
@requires_role(Role.VIEWER)
async def read(recording_id: RecordingId, bridge: BridgeDep) -> Recording:
    return await bridge.recordings.get(recording_id)


@router.post("/{recording_id}/stop")
@requires_role(Role.OPERATOR)
async def stop(recording_id: RecordingId, bridge: BridgeDep) -> Recording:
    """Closes the file; one that has ended stays as it ended."""
    return await bridge.recordings.stop(recording_id)


@router.get(
    "/{recording_id}/file",
    response_class=FileResponse,
    responses={200: {"content": {"application/octet-stream": {}}}},
)
@requires_role(Role.VIEWER)
async def fetch(recording_id: RecordingId, bridge: BridgeDep) -> FileResponse:
    """The MCAP file, for Foxglove or `ros2 bag`; 409 while it is being written, 404 where
    nothing was kept."""
    path = await bridge.recordings.file(recording_id)
    return FileResponse(path, media_type="application/octet-stream", filename=path.name)


@router.delete("/{recording_id}", status_code=204)
@requires_role(Role.ADMIN)
async def delete(recording_id: RecordingId, bridge: BridgeDep) -> None:
    await bridge.recordings.delete(recording_id)
