"""The whole memory as a file, to keep or to carry elsewhere, and back."""

from typing import Any, Final

from fastapi import APIRouter
from fastapi.responses import Response
from starlette.requests import Request

from mesh.access import Role, requires_role
from ui.operator_actions import ActionResult
from ui.routes.deps import ActionsDep, DeskDep

router = APIRouter(tags=["memory"])

FILE: Final[dict[int | str, dict[str, Any]]] = {200: {"content": {"application/x-ndjson": {}}}}

BODY: Final[dict[str, Any]] = {
    "requestBody": {
        "required": True,
        "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
    }
}


@router.get("/memory/export", responses=FILE, response_class=Response)
@requires_role(Role.VIEWER)
async def export(desk: DeskDep) -> Response:
    """What memory exports, as a download."""
    headers = {"Content-Disposition": 'attachment; filename="atom-memory.jsonl"', "Cache-Control": "no-store"}
    return Response(await desk.memory.export(), media_type="application/x-ndjson", headers=headers)


@router.post("/memory/import", openapi_extra=BODY)
@requires_role(Role.ADMIN)
async def import_memory(request: Request, actions: ActionsDep) -> ActionResult:
    """Takes an exported file back. A refusal is an answer: `ok` is false and `text` says why."""
    return await actions.import_memory(await request.body())
