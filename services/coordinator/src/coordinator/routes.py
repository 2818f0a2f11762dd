"""HTTP: missions, state, coverage, and the timeline as a stream."""

import asyncio
import contextlib
from typing import Annotated

from fastapi import APIRouter, Depends, Path, Query, WebSocket, WebSocketDisconnect
from starlette.requests import HTTPConnection

from contracts.mission import CoveragePlan, Mission, MissionEvent, MissionStatus, StartMission
from coordinator.missions import Missions

router = APIRouter()


def get_missions(connection: HTTPConnection) -> Missions:
    missions: Missions = connection.state.missions
    return missions


MissionsDep = Annotated[Missions, Depends(get_missions)]
MissionId = Annotated[str, Path(min_length=1, max_length=64)]
After = Annotated[int, Query(ge=-1, le=2**53, description="only events with a higher id")]


@router.post("/missions", status_code=201, tags=["missions"])
async def start(body: StartMission, missions: MissionsDep) -> Mission:
    """Starts a mission. 409 while one runs or the robot is stopped, 422 when the command names nothing known."""
    return await missions.start(body.command)


@router.get("/missions", tags=["missions"])
async def newest(missions: MissionsDep, limit: Annotated[int, Query(ge=1, le=200)] = 20) -> list[Mission]:
    """Newest first."""
    return list(missions.log.newest(limit))


@router.get("/missions/{mission_id}", tags=["missions"])
async def read(mission_id: MissionId, missions: MissionsDep) -> Mission:
    return missions.get(mission_id)


@router.get("/missions/{mission_id}/events", tags=["missions"])
async def events(
    mission_id: MissionId, missions: MissionsDep, after: After = -1, limit: Annotated[int, Query(ge=1, le=2000)] = 1000
) -> list[MissionEvent]:
    """Its timeline, oldest first."""
    missions.get(mission_id)
    return list(missions.log.events(mission_id, after=after, limit=limit))


@router.post("/missions/{mission_id}/cancel", tags=["missions"])
async def cancel(mission_id: MissionId, missions: MissionsDep) -> Mission:
    """Stops and ends it; 409 when it has ended already."""
    return missions.cancel(mission_id)


@router.post("/missions/{mission_id}/pause", tags=["missions"])
async def pause(mission_id: MissionId, missions: MissionsDep) -> Mission:
    """Stops where it is; 409 unless it runs."""
    return missions.pause(mission_id)


@router.post("/missions/{mission_id}/resume", tags=["missions"])
async def resume(mission_id: MissionId, missions: MissionsDep) -> Mission:
    """Goes on with the state it was paused in; 409 unless it is paused."""
    return missions.resume(mission_id)


@router.get("/state", tags=["state"])
async def state(missions: MissionsDep) -> MissionStatus:
    """What `mission.state` says, now."""
    return missions.runner.status()


@router.get("/coverage", tags=["state"])
async def coverage(missions: MissionsDep) -> CoveragePlan:
    """Where a search would look, for the current map, from where the robot stands."""
    return await missions.coverage()


@router.websocket("/events")
async def stream(
    socket: WebSocket, missions: MissionsDep, after: Annotated[int | None, Query(ge=-1, le=2**53)] = None
) -> None:
    """Every timeline event as JSON: those kept with a higher id than `after`, then each as it comes."""
    await socket.accept()
    sending = asyncio.ensure_future(_send(socket, missions, after))
    leaving = asyncio.ensure_future(_left(socket))
    try:
        await asyncio.wait({sending, leaving}, return_when=asyncio.FIRST_COMPLETED)
    finally:
        sending.cancel()
        leaving.cancel()
        await asyncio.gather(sending, leaving, return_exceptions=True)


async def _send(socket: WebSocket, missions: Missions, after: int | None) -> None:
    with contextlib.suppress(WebSocketDisconnect, RuntimeError):
        async for event in missions.log.follow(after=after):
            await socket.send_text(event.model_dump_json())


async def _left(socket: WebSocket) -> None:
    while (await socket.receive())["type"] != "websocket.disconnect":
        pass
