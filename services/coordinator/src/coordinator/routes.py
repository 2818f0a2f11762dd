"""HTTP: missions, questions, state, coverage, and the timeline as a stream."""

import asyncio
import contextlib
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Header, Path, Query, WebSocket, WebSocketDisconnect
from starlette.requests import HTTPConnection, Request
from starlette.responses import PlainTextResponse, Response, StreamingResponse

from contracts.asking import Answer, Question
from contracts.backup import RestoreHold, RestoreReply
from contracts.belief import SearchBelief
from contracts.intent import Understand, Understood
from contracts.mission import CoveragePlan, Heard, Mission, MissionEvent, MissionStatus, StartMission
from coordinator.action_routes import ActionsDep
from coordinator.commands.mission_service import MissionService
from mesh.access import Role, principal_of, requires_role
from mesh.tracing import TracedRoute
from store.sending import DATABASE_BODY, DATABASE_RESPONSE, answer_with

router = APIRouter(route_class=TracedRoute)


async def get_missions(connection: HTTPConnection) -> MissionService:
    """Async, as all of them: FastAPI would send a plain function to another thread and back, on every call."""
    missions: MissionService = connection.state.missions
    return missions


MissionsDep = Annotated[MissionService, Depends(get_missions)]
MissionId = Annotated[str, Path(min_length=1, max_length=64)]
After = Annotated[int, Query(ge=-1, le=2**53, description="only events with a higher id")]


HEARD: dict[int | str, dict[str, Any]] = {200: {"model": Heard, "description": "an order that was obeyed"}}
Key = Annotated[str | None, Header(alias="Idempotency-Key", min_length=1, max_length=100)]


@router.post("/missions", status_code=201, tags=["missions"], responses=HEARD)
@requires_role(Role.OPERATOR)
async def start(body: StartMission, missions: MissionsDep, response: Response, key: Key = None) -> Mission | Heard:
    """An order ('stop', 'wait', 'never mind the cup') is obeyed at once, before anything is parsed: 200. Else the first
    mission of the command: it begins at once, or waits while another runs; further things the command names follow as
    missions of their own with the same `request_id`. 409 while the robot is stopped or low on power, 422 when the
    command names nothing known or asks for nothing (`code` says which), 429 when the queue is full.
    """
    told = await missions.start(body.command, key)
    if isinstance(told, Heard):
        response.status_code = 200
    return told


@router.post("/understand", tags=["missions"])
@requires_role(Role.VIEWER)
async def understand(body: Understand, missions: MissionsDep) -> Understood:
    """What a saying means, as typed data, or the question back where its readings differ. It starts and stops nothing:
    what is to be done is sent on, an intent's `command` to `POST /missions` or, where its action is a question, to
    `POST /ask`. 503 where nobody reads.
    """
    return await missions.reader.understand(body.readings)


@router.get("/missions", tags=["missions"])
@requires_role(Role.VIEWER)
async def newest(
    missions: MissionsDep,
    limit: Annotated[int, Query(ge=1, le=200)] = 20,
    before: Annotated[str | None, Query(min_length=1, max_length=64, description="id: only older ones")] = None,
) -> list[Mission]:
    """Newest first; the next page is asked for with `before` = the last one's id."""
    return list(await missions.log.newest(limit, before=before))


@router.get("/missions/{mission_id}", tags=["missions"])
@requires_role(Role.VIEWER)
async def read(mission_id: MissionId, missions: MissionsDep) -> Mission:
    return await missions.get(mission_id)


@router.get("/missions/{mission_id}/events", tags=["missions"])
@requires_role(Role.VIEWER)
async def events(
    mission_id: MissionId, missions: MissionsDep, after: After = -1, limit: Annotated[int, Query(ge=1, le=2000)] = 1000
) -> list[MissionEvent]:
    """Its timeline, oldest first."""
    await missions.get(mission_id)
    return list(await missions.log.events(mission_id, after=after, limit=limit))


@router.get("/missions/{mission_id}/recording", tags=["missions"], response_class=PlainTextResponse)
@requires_role(Role.VIEWER)
async def recording(mission_id: MissionId, missions: MissionsDep) -> PlainTextResponse:
    """Everything it was decided by, one JSON object a line: the settings, then each event with its time and what was
    decided on it. `make replay` decides it again.
    """
    return PlainTextResponse(await missions.recording(mission_id), media_type="application/x-ndjson")


@router.get(
    "/missions/{mission_id}/pictures/{number}",
    tags=["missions"],
    response_class=Response,
    responses={200: {"content": {"image/jpeg": {}}}},
)
@requires_role(Role.VIEWER)
async def picture(
    mission_id: MissionId, number: Annotated[int, Path(ge=0, le=10_000)], missions: MissionsDep
) -> Response:
    """What was judged, as it was seen (JPEG)."""
    return Response(await missions.picture(mission_id, number), media_type="image/jpeg")


@router.get("/missions/{mission_id}/belief", tags=["missions"])
@requires_role(Role.VIEWER)
async def belief(mission_id: MissionId, missions: MissionsDep) -> SearchBelief:
    """Where the target of the mission that runs probably is, after every look so far, and which view was chosen by it.
    404 where there is none; `code` says why: `not_begun`, `ended`, `another_rule`, `nothing_chosen`.
    """
    return await missions.belief(mission_id)


@router.post("/missions/{mission_id}/cancel", tags=["missions"])
@requires_role(Role.OPERATOR)
async def cancel(mission_id: MissionId, missions: MissionsDep) -> Mission:
    """Stops and ends it, or takes it out of the queue; 409 when it has ended already."""
    return await missions.cancel(mission_id)


@router.post("/missions/{mission_id}/pause", tags=["missions"])
@requires_role(Role.OPERATOR)
async def pause(
    mission_id: MissionId,
    missions: MissionsDep,
    for_s: Annotated[
        float | None,
        Query(ge=0.0, le=60.0, description="it goes on by itself after so long, 0 = now; none = when a person says"),
    ] = None,
) -> Mission:
    """Stops where it is; 409 unless it runs. With `for_s` it stands while somebody speaks to the robot: asked for again
    it stands so much longer from now, and a pause without `for_s` takes its place. One that a person asked for is
    neither shortened nor ended by it (409).
    """
    return await missions.pause(mission_id, for_s=for_s)


@router.post("/missions/{mission_id}/resume", tags=["missions"])
@requires_role(Role.OPERATOR)
async def resume(mission_id: MissionId, missions: MissionsDep) -> Mission:
    """Goes on with the state it was paused in; 409 unless it is paused."""
    return await missions.resume(mission_id)


@router.post("/ask", tags=["asking"])
@requires_role(Role.VIEWER)
async def ask(body: Question, asking: Request, actions: ActionsDep) -> Answer:
    """An answer from what memory, the missions and the robot know, with the records it rests on. It moves nothing; an
    order ('stop') is obeyed here too, 'go on' from an operator only.
    """
    return await actions.answer(body.question, principal_of(asking))


@router.get("/state", tags=["state"])
@requires_role(Role.VIEWER)
async def state(missions: MissionsDep) -> MissionStatus:
    """What `mission.state` says, now."""
    return missions.runner.status()


@router.get("/coverage", tags=["state"])
@requires_role(Role.VIEWER)
async def coverage(missions: MissionsDep) -> CoveragePlan:
    """Where a search would look, for the current map, from where the robot stands."""
    return await missions.coverage()


@router.get(
    "/backup",
    tags=["exchange"],
    response_class=StreamingResponse,
    responses=DATABASE_RESPONSE,
)
@requires_role(Role.ADMIN)
async def backup(missions: MissionsDep) -> StreamingResponse:
    """The history of missions at one moment, as an SQLite file; `X-Schema-Revision` tells its schema. A mission that
    runs is in it as far as it has come. 409 while another copy is made. `atom backup` asks for it.
    """
    return answer_with(await missions.log.snapshot(), "coordinator.db")


@router.post(
    "/restore",
    tags=["exchange"],
    openapi_extra=DATABASE_BODY,
)
@requires_role(Role.ADMIN)
async def restore(
    request: Request,
    missions: MissionsDep,
    dry_run: Annotated[bool, Query(description="check what is sent, and change nothing")] = False,
) -> RestoreReply:
    """The history becomes what the SQLite file that is sent holds, whole or not at all; the one before stays in a file
    beside it. 409 (`mission_on`) while a mission runs or waits; 422 for what is damaged, not the coordinator's, or of
    a newer program.
    """
    return await missions.restore(request.stream(), dry_run=dry_run)


@router.post("/restore/hold", tags=["exchange"])
@requires_role(Role.ADMIN)
async def hold(body: RestoreHold, missions: MissionsDep) -> RestoreHold:
    """Nothing begins for so many seconds, while several services are restored: who asks for a mission gets 409
    (`restoring`), and the robot does not set out for its dock. Stops are obeyed as ever. Asked for again it lasts from
    then on, 0 ends it, and what still waits to begin. 409 (`mission_on`) while a mission runs or waits.
    """
    return await missions.hold(body)


@router.websocket("/events")
@requires_role(Role.VIEWER)
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


async def _send(socket: WebSocket, missions: MissionService, after: int | None) -> None:
    with contextlib.suppress(WebSocketDisconnect, RuntimeError):
        async for event in missions.log.follow(after=after):
            await socket.send_text(event.model_dump_json())


async def _left(socket: WebSocket) -> None:
    while (await socket.receive())["type"] != "websocket.disconnect":
        pass
