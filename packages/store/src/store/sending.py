"""A database as the body of a request or of an answer."""

import asyncio
from collections.abc import AsyncGenerator
from typing import Any, Final

from fastapi.responses import StreamingResponse

from contracts.backup import SCHEMA_HEADER
from store.copies import DatabaseCopy

PART_BYTES: Final = 1 << 18
"""A reader who takes nothing of it for `mesh.server.ANSWER_WAIT_S_MAX` is let go, and with him the file."""
MEDIA_TYPE: Final = "application/octet-stream"
_CONTENT: Final[dict[str, Any]] = {MEDIA_TYPE: {"schema": {"type": "string", "format": "binary"}}}
DATABASE_BODY: Final[dict[str, Any]] = {"requestBody": {"required": True, "content": _CONTENT}}
DATABASE_RESPONSE: Final[dict[int | str, dict[str, Any]]] = {200: {"content": _CONTENT}}


def answer_with(snapshot: DatabaseCopy, name: str) -> StreamingResponse:
    """Its length is told before: a reader knows when something is missing. `name` is the file's for a browser."""
    headers = {
        "content-length": str(snapshot.size_bytes),
        "content-disposition": f'attachment; filename="{name}"',
        SCHEMA_HEADER: snapshot.revision,
    }
    return StreamingResponse(_parts(snapshot), media_type=MEDIA_TYPE, headers=headers)


async def _parts(snapshot: DatabaseCopy) -> AsyncGenerator[bytes]:
    with snapshot.file as file:
        while part := await asyncio.to_thread(file.read, PART_BYTES):
            yield part
