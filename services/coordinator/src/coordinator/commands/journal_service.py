"""Back-up and restore of what explorations know of each home."""

from collections.abc import AsyncIterable

from contracts.backup import RestoreReply
from coordinator.commands.mission_service import MissionService
from coordinator.commands.restoring import restored
from coordinator.exploration_ports import CopiedJournal
from coordinator.settings import Settings
from store.copies import DatabaseCopy


class JournalService:
    def __init__(self, settings: Settings, missions: MissionService, journal: CopiedJournal) -> None:
        self._settings = settings
        self._missions = missions
        self._journal = journal

    async def snapshot(self) -> DatabaseCopy:
        """Raises `ConflictError` while another copy is made, `UnavailableError` without the database."""
        return await self._journal.snapshot()

    async def restore(self, body: AsyncIterable[bytes], *, dry_run: bool) -> RestoreReply:
        """The journal becomes what a snapshot holds; `dry_run`: it is only checked. Raises `ConflictError` while a
        mission runs or waits (it may explore), `UnprocessableError` for what is no journal of ours, `TooLargeError`,
        `UnavailableError`."""
        candidate = self._journal.candidate(body, bytes_max=self._settings.restore_bytes_max)
        return await restored(candidate, self._journal.replace, at_rest=self._missions.at_rest, dry_run=dry_run)
