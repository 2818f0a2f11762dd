"""A snapshot as the body of an answer."""

import asyncio
from collections.abc import AsyncGenerator
from typing import Final

from fastapi.responses import StreamingResponse

from contracts.backup import SCHEMA_HEADER
from store.copies import DatabaseCopy

PART_BYTES: Final = 1 << 20
MEDIA_TYPE: Final = "application/octet-stream"


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
