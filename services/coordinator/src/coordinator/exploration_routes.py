"""HTTP: what explorations know of each home, as a database that is copied and comes back."""

from typing import Annotated

from fastapi import APIRouter, Depends, Query, Request
from fastapi.requests import HTTPConnection
from fastapi.responses import StreamingResponse

from contracts.backup import RestoreReply
from coordinator.commands.journal_service import JournalService
from mesh.access import Role, requires_role
from mesh.tracing import TracedRoute
from store.sending import DATABASE_BODY, DATABASE_RESPONSE, answer_with

router = APIRouter(route_class=TracedRoute)


async def get_journals(connection: HTTPConnection) -> JournalService:
    journals: JournalService = connection.state.journals
    return journals


JournalsDep = Annotated[JournalService, Depends(get_journals)]


@router.get(
    "/exploration/backup",
    tags=["exchange"],
    response_class=StreamingResponse,
    responses=DATABASE_RESPONSE,
)
@requires_role(Role.ADMIN)
async def backup(journals: JournalsDep) -> StreamingResponse:
    """What explorations found out of each home, at one moment, as an SQLite file; `X-Schema-Revision` tells its schema.
    409 while another copy is made. `atom backup` asks for it.
    """
    return answer_with(await journals.snapshot(), "exploration.db")


@router.post(
    "/exploration/restore",
    tags=["exchange"],
    openapi_extra=DATABASE_BODY,
)
@requires_role(Role.ADMIN)
async def restore(
    request: Request,
    journals: JournalsDep,
    dry_run: Annotated[bool, Query(description="check what is sent, and change nothing")] = False,
) -> RestoreReply:
    """What is known of each home becomes what the SQLite file that is sent holds, whole or not at all; the one before
    stays in a file beside it. 409 (`mission_on`) while a mission runs or waits; 422 for what is damaged, another
    program's, or of a newer one.
    """
    return await journals.restore(request.stream(), dry_run=dry_run)
