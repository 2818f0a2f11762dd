"""The HTTP face: thin; every decision is made behind it."""

from collections.abc import AsyncGenerator
from typing import Annotated

from fastapi import APIRouter, Depends, Path, Query, Request
from fastapi.responses import Response, StreamingResponse

from contracts.backup import RestoreReply
from contracts.base import Label
from contracts.memory import (
    ColourWord,
    DeletedReply,
    ExportForm,
    ForgetRequest,
    ImportReply,
    LabelCount,
    LookBatch,
    LooksReply,
    MemoryStatistics,
    ObjectState,
    ObservationBatch,
    ObservationsReply,
    RecallReply,
    RecallRequest,
    RememberedMap,
    RememberedObject,
    View,
)
from contracts.rooms import NamedRoom, NameRoom, RoomGrid, RoomsReply
from memory.memory_service import MemoryService
from memory.metrics import RECALLS
from mesh.access import Role, requires_role
from mesh.tracing import TracedRoute
from store.sending import DATABASE_BODY, DATABASE_RESPONSE, answer_with

router = APIRouter(route_class=TracedRoute)

MEDIA = {ExportForm.FULL: "application/x-ndjson", ExportForm.SEEDS: "application/json"}
FILE = {ExportForm.FULL: "memory.jsonl", ExportForm.SEEDS: "memory.json"}


async def get_memory(request: Request) -> MemoryService:
    """Async: FastAPI would send a plain function to another thread and back, on every call."""
    return request.state.memory


MemoryDep = Annotated[MemoryService, Depends(get_memory)]
InMap = Annotated[
    str | None, Query(alias="map", max_length=40, description="a map's id, see /maps; none: the one the robot is in")
]
Number = Annotated[int, Path(ge=1, le=2**31 - 1)]


@router.post("/observations", tags=["writing"])
@requires_role(Role.SERVICE)
async def observe(body: ObservationBatch, memory: MemoryDep) -> ObservationsReply:
    """Remembers; durable when answered. Excluded labels are counted as ignored and written nowhere."""
    return await memory.observe(body)


@router.post("/looks", tags=["writing"])
@requires_role(Role.SERVICE)
async def look(body: LookBatch, memory: MemoryDep) -> LooksReply:
    """What should have been seen and was not loses belief; what was hidden or out of view keeps it."""
    return await memory.look(body)


@router.get("/labels", tags=["reading"])
@requires_role(Role.VIEWER)
async def labels(
    memory: MemoryDep, limit: Annotated[int, Query(ge=1, le=1000)] = 500, in_map: InMap = None
) -> list[LabelCount]:
    """What is remembered at all of a map, most views first."""
    return await memory.labels(limit, in_map)


@router.get("/maps", tags=["reading"])
@requires_role(Role.VIEWER)
async def maps(memory: MemoryDep) -> list[RememberedMap]:
    """Homes that something is remembered of, the one the robot is in first."""
    return await memory.maps()


@router.get("/rooms", tags=["reading"])
@requires_role(Role.VIEWER)
async def rooms(memory: MemoryDep) -> RoomsReply:
    """The rooms of the map the robot is in, by name; none where there is no map now, 503 where it is not cut yet."""
    return await memory.rooms.rooms()


@router.get("/rooms/grid", tags=["reading"])
@requires_role(Role.VIEWER)
async def room_grid(memory: MemoryDep) -> RoomGrid:
    """Where those rooms lie, cell by cell; 404 where there is no map now, 503 where it is not cut yet."""
    return await memory.rooms.grid()


@router.put("/rooms/{number}/name", tags=["writing"])
@requires_role(Role.OPERATOR)
async def name_room(number: Number, body: NameRoom, memory: MemoryDep) -> NamedRoom:
    """Gives a room a person's name, or takes it away (''); 404 when there is no such room, 409 when another has it."""
    return await memory.rooms.name(number, body.name)


@router.get("/views", tags=["reading"])
@requires_role(Role.VIEWER)
async def views(
    memory: MemoryDep,
    label: Annotated[Label | None, Query()] = None,
    limit: Annotated[int, Query(ge=1, le=5000)] = 100,
    in_map: InMap = None,
) -> list[View]:
    """Robot poses from which a thing (or anything) was seen, confidence descending."""
    return await memory.views(label, limit, in_map)


@router.get("/objects", tags=["reading"])
@requires_role(Role.VIEWER)
async def objects(
    memory: MemoryDep,
    label: Annotated[Label | None, Query()] = None,
    state: Annotated[ObjectState | None, Query()] = None,
    colour: Annotated[ColourWord | None, Query()] = None,
    room: Annotated[int | None, Query(ge=1, le=2**31 - 1, description="a room's id, see /rooms")] = None,
    limit: Annotated[int, Query(ge=1, le=5000)] = 200,
    in_map: InMap = None,
) -> list[RememberedObject]:
    """Things with a place of their own, most believed first, each with the room it stands in once the map is cut into
    rooms; `room` waits for that, and is a 503 where it takes too long."""
    return await memory.objects(label, state, colour, limit, in_map, room)


@router.get("/objects/{number}", tags=["reading"])
@requires_role(Role.VIEWER)
async def one_object(number: Number, memory: MemoryDep) -> RememberedObject:
    """One thing; 404 when there is none."""
    return await memory.object(number)


@router.post("/recall", tags=["reading"])
@requires_role(Role.VIEWER)
async def recall(body: RecallRequest, memory: MemoryDep) -> RecallReply:
    """Where to look for it, best first, each with the parts of its score and the reason in words."""
    with RECALLS.time():
        return await memory.recall(body)


@router.delete("/objects/{number}", tags=["writing"])
@requires_role(Role.OPERATOR)
async def forget_object(number: Number, memory: MemoryDep) -> DeletedReply:
    """Forgets a thing and every view of it; 404 when there is none."""
    return await memory.forget_object(number)


@router.delete("/labels/{label:path}", tags=["writing"])
@requires_role(Role.OPERATOR)
async def forget_label(label: Annotated[Label, Path()], memory: MemoryDep) -> DeletedReply:
    """Forgets everything of a label; 404 when there is nothing."""
    return await memory.forget(ForgetRequest(label=label))


@router.post("/forget", tags=["writing"])
@requires_role(Role.OPERATOR)
async def forget(body: ForgetRequest, memory: MemoryDep) -> DeletedReply:
    """Forgets by label, area and time; 404 when nothing meets all that is asked."""
    return await memory.forget(body)


@router.get(
    "/export",
    tags=["exchange"],
    response_class=StreamingResponse,
    responses={200: {"content": {"application/x-ndjson": {}, "application/json": {}}}},
)
@requires_role(Role.VIEWER)
async def export(memory: MemoryDep, form: Annotated[ExportForm, Query()] = ExportForm.FULL) -> StreamingResponse:
    """Everything remembered, as a file."""
    lines = memory.export(form)
    first = await anext(lines)  # a database that is away is a 503, not a broken file
    headers = {"content-disposition": f'attachment; filename="{FILE[form]}"'}
    return StreamingResponse(_from(first, lines), media_type=MEDIA[form], headers=headers)


@router.post(
    "/import",
    tags=["exchange"],
    openapi_extra={
        "requestBody": {
            "required": True,
            "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
        }
    },
)
@requires_role(Role.SERVICE)
async def import_batch(
    request: Request, memory: MemoryDep, form: Annotated[ExportForm, Query()] = ExportForm.FULL
) -> ImportReply:
    """Takes an export back, all of it or nothing; doing it twice changes nothing."""
    return await memory.import_batch(form, await request.body())


@router.get(
    "/backup",
    tags=["exchange"],
    response_class=StreamingResponse,
    responses=DATABASE_RESPONSE,
)
@requires_role(Role.ADMIN)
async def backup(memory: MemoryDep) -> StreamingResponse:
    """Everything remembered at one moment, as an SQLite file; `X-Schema-Revision` tells its schema. 409 while another
    copy is made; 422 (`use_pg_dump`) where memory is kept in PostgreSQL. `atom backup` asks for it.
    """
    return answer_with(await memory.snapshot(), "memory.db")


@router.post(
    "/restore",
    tags=["exchange"],
    openapi_extra=DATABASE_BODY,
)
@requires_role(Role.ADMIN)
async def restore(
    request: Request,
    memory: MemoryDep,
    dry_run: Annotated[bool, Query(description="check what is sent, and change nothing")] = False,
) -> RestoreReply:
    """What is remembered becomes what the SQLite file that is sent holds, whole or not at all; what was remembered
    before stays in a file beside it. 422 for what is damaged, not memory's, or of a newer program.
    """
    return await memory.restore(request.stream(), dry_run=dry_run)


@router.get(
    "/map.svg",
    tags=["reading"],
    response_class=Response,
    responses={200: {"content": {"image/svg+xml": {}}}},
)
@requires_role(Role.VIEWER)
async def picture(
    memory: MemoryDep,
    label: Annotated[Label | None, Query()] = None,
    views: Annotated[int, Query(ge=0, le=5000)] = 500,
) -> Response:
    """Objects by belief and age, and the best views, on the map."""
    return Response(await memory.map_svg(label, views), media_type="image/svg+xml")


@router.get("/statistics", tags=["reading"])
@requires_role(Role.VIEWER)
async def statistics(memory: MemoryDep) -> MemoryStatistics:
    """How much is remembered, and how large it is."""
    return await memory.statistics()


async def _from(first: str, rest: AsyncGenerator[str]) -> AsyncGenerator[str]:
    yield first
    async for part in rest:
        yield part
