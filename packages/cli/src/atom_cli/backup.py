"""`atom backup` and `atom restore`: what cannot be made again, as one file.

Everything is checked before anything changes: the archive here, each database by the service it is for. Then one
service after the other takes its own over. Where a later one does not, the earlier ones get back what they had.
"""

import tempfile
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from atom_cli import archive
from atom_cli.services import AwayError, RefusedError, ServiceError, Services
from contracts.backup import BackupManifest, BackupService, RestoreReply

EVERY = (BackupService.COORDINATOR, BackupService.EXPLORATION, BackupService.MEMORY)
"""In the order they are restored in: the coordinator is the one that may say no."""
THE_COORDINATORS = frozenset({BackupService.COORDINATOR, BackupService.EXPLORATION})
HELD_S = 600.0
"""So long no mission begins when this program dies in the middle; one service takes less, or is not waited for."""


class NotPutBackError(Exception):
    """A restore failed halfway, and what was there before could not be put back either."""


class MissionOnError(Exception):
    pass


@dataclass(eq=False)  # not frozen: a traceback is set on it
class HalfwayError(Exception):
    """`put_back` have again what they had before. `failed` did not take its database, or, where it is `unknown`, did
    not say so: nobody waited for it any longer."""

    failed: BackupService
    cause: ServiceError | KeyboardInterrupt
    put_back: tuple[BackupService, ...]

    @property
    def unknown(self) -> bool:
        return not isinstance(self.cause, RefusedError)


def back_up(services: Services, path: Path, wanted: Sequence[BackupService], made_s: float) -> BackupManifest:
    """Raises `ServiceError`, `archive.ArchiveError`, `OSError`."""
    with tempfile.TemporaryDirectory(prefix=".atom-backup-", dir=path.parent) as folder:
        taken = [(one, *_taken(services, one, Path(folder))) for one in wanted]
        made = Path(folder) / "archive"
        manifest = archive.write(made, made_s, taken)
        made.replace(path)
        return manifest


def restore(
    services: Services, files: Mapping[BackupService, Path], wanted: Sequence[BackupService], *, dry_run: bool
) -> dict[BackupService, RestoreReply]:
    """What each service says. Raises `ServiceError` or `MissionOnError` when nothing has changed, else `HalfwayError`
    or `NotPutBackError`; `KeyboardInterrupt` only while it is checked."""
    if THE_COORDINATORS.isdisjoint(wanted):  # it says so itself
        _check_at_rest(services)
    checked = {one: services.restore(one, files[one], dry_run=True) for one in wanted}
    if dry_run:
        return checked
    with _no_mission_begins(services, wanted) as hold:
        return _replaced(services, files, wanted, hold)


def _replaced(
    services: Services, files: Mapping[BackupService, Path], wanted: Sequence[BackupService], hold: Callable[[], None]
) -> dict[BackupService, RestoreReply]:
    done: dict[BackupService, RestoreReply] = {}
    with tempfile.TemporaryDirectory(prefix=".atom-restore-", dir=next(iter(files.values())).parent) as folder:
        before = {one: _taken(services, one, Path(folder))[1] for one in wanted[:-1]}
        for one in wanted:
            try:
                hold()
                done[one] = services.restore(one, files[one], dry_run=False)
            except (ServiceError, KeyboardInterrupt) as error:
                if not done and isinstance(error, RefusedError):
                    raise
                _put_back(services, {each: before[each] for each in done}, error)
                raise HalfwayError(one, error, tuple(done)) from error
    return done


@contextmanager
def _no_mission_begins(services: Services, wanted: Sequence[BackupService]) -> Generator[Callable[[], None]]:
    """Between one service and the next a mission would begin with the history of one time and the memory of another.
    What is given begins the time anew."""

    def hold() -> None:
        try:
            services.hold_missions(HELD_S)
        except AwayError:  # no coordinator, no mission
            if not THE_COORDINATORS.isdisjoint(wanted):
                raise

    try:
        hold()
        yield hold
    finally:
        with suppress(ServiceError):
            services.hold_missions(0.0)


def _check_at_rest(services: Services) -> None:
    try:
        now = services.status()
    except AwayError:  # no coordinator, no mission
        return
    if now.queue or (now.mission is not None and now.mission.outcome is None):
        raise MissionOnError("a mission runs or waits: cancel it, or wait for its end")


def _put_back(services: Services, before: Mapping[BackupService, Path], cause: BaseException) -> None:
    for one, file in before.items():
        try:
            services.restore(one, file, dry_run=False)
        except ServiceError as error:
            raise NotPutBackError(
                f"{str(cause) or 'interrupted'}; and {one} could not be given back what it had ({error}): "
                "it is in the file beside its database whose name ends in before-restore-, with the highest number"
            ) from error


def _taken(services: Services, service: BackupService, folder: Path) -> tuple[str, Path]:
    """The revision of its schema, and the file."""
    place = folder / f"{service}.db"
    with archive.sealed(place) as file:
        return services.back_up(service, file), place
