"""A database of the coordinator becomes what a snapshot holds, while no mission runs or waits."""

from collections.abc import Awaitable, Callable
from contextlib import AbstractAsyncContextManager

import structlog

from contracts.backup import RestoreReply
from store.copies import JudgedDatabase

log = structlog.get_logger()


async def restored(
    candidate: AbstractAsyncContextManager[JudgedDatabase],
    replace: Callable[[JudgedDatabase], Awaitable[str]],
    *,
    at_rest: Callable[[], AbstractAsyncContextManager[None]],
    dry_run: bool,
) -> RestoreReply:
    """`dry_run`: it is only checked. `replace` names the file that keeps what was there before. Raises `ConflictError`
    where `at_rest` does, before anything is sent and again before anything is replaced."""
    async with at_rest():
        pass
    async with candidate as judged:
        kept = ""
        if not dry_run:
            async with at_rest():
                kept = await replace(judged)
            log.warning("a database was replaced by a back-up", rows=judged.rows, before=kept)
        return RestoreReply(applied=not dry_run, revision=judged.revision, rows=judged.rows, kept_as=kept)
