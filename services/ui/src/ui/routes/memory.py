"""The whole memory as a file, to keep or to carry elsewhere."""

from typing import Any, Final

from fastapi import APIRouter
from fastapi.responses import Response

from ui.routes.deps import DeskDep

router = APIRouter(tags=["memory"])

FILE: Final[dict[int | str, dict[str, Any]]] = {200: {"content": {"application/x-ndjson": {}}}}


@router.get("/memory/export", responses=FILE, response_class=Response)
async def export(desk: DeskDep) -> Response:
    """What memory exports, as a download."""
    headers = {"Content-Disposition": 'attachment; filename="atom-memory.jsonl"', "Cache-Control": "no-store"}
    return Response(await desk.memory.export(), media_type="application/x-ndjson", headers=headers)
