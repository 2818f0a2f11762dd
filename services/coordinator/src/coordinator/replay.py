"""Decides a recorded mission again, offline and step by step: `python -m coordinator.replay MISSION`.

MISSION is a file of recorded lines, or the id (or its start) of a mission in the database. Each step shows
what came in, what was decided, and whether it is what was decided then ("!" where not). Ends with status 1 where not.
"""

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

from coordinator.adapters.recordings import stored_recording
from coordinator.core import actions as do
from coordinator.core import events as ev
from coordinator.core.recording import MalformedRecordingError, Recording, Replayed, read, replay
from coordinator.settings import Settings
from mesh.errors import MeshError

WIDTH = 110


def recording_of(mission: str, database: Path) -> Recording:
    """Raises `MeshError`, `MalformedRecordingError`, `OSError`."""
    path = Path(mission)
    if path.is_file():
        with path.open(encoding="utf-8") as lines:
            return read(lines)
    return read(stored_recording(database, mission))


def lines_of(recording: Recording, *, every: bool) -> Iterator[str]:
    """One block of text for each step worth showing, then how many steps were decided as recorded."""
    header, total, other = recording.header, 0, 0
    yield f"mission {header.mission_id}: {len(recording.steps)} recorded steps"
    for one in replay(recording):
        total += 1
        other += not one.same
        if every or one.actions or not one.same or one.before.state is not one.after.state:
            yield block(one, header.begun_s)
    if recording.steps:
        yield f"it ended {recording.steps[-1].state.value}"
    yield f"{total - other} of {total} steps decided as recorded"


def block(one: Replayed, begun_s: float) -> str:
    before, after = one.before.state, one.after.state
    arrow = before.value if before is after else f"{before.value} -> {after.value}"
    mark = " " if one.same else "!"
    text = [f"{mark} {one.recorded.now_s - begun_s:8.2f} s  {arrow:28} on {told(one.recorded.event)}"]
    text += [f"{'':14}{told(action)}" for action in one.actions]
    if not one.same:
        text.append(f"{'':14}RECORDED: {one.recorded.state.value}")
        text += [f"{'':14}RECORDED: {told(action)}" for action in one.recorded.actions]
    return "\n".join(text)


def told(what: ev.Event | do.Action) -> str:
    """An event or an action in one line."""
    match what:
        case do.Say(kind=kind, text=text):
            line = f'says ({kind}) "{text}"'
        case ev.DetectionsSeen(detections=seen):
            boxes = ", ".join(f"{d.colour or ''} {d.label} {d.confidence:.2f}".strip() for d in seen.detections)
            line = f"DetectionsSeen({boxes or 'nothing'})"
        case ev.Validated(call=call, validation=validation):
            votes = ", ".join(f"{v.voter} {v.verdict.value}" for v in validation.votes)
            line = f"Validated({call}: {'yes' if validation.confirmed else 'no'}; {votes})"
        case _:
            line = str(what)
    return line if len(line) <= WIDTH else line[: WIDTH - 1] + "…"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mission", help="a file, or a mission's id")
    parser.add_argument("--database", type=Path, default=None, help="default: the file of COORDINATOR_DATABASE_URL")
    parser.add_argument("--every", action="store_true", help="show the steps that asked for nothing, too")
    options = parser.parse_args()
    database = options.database or Settings.read().database_file
    try:
        recording = recording_of(options.mission, database)
    except (MeshError, MalformedRecordingError, OSError) as error:
        sys.stderr.write(f"{error}\n")
        return 2
    for line in lines_of(recording, every=options.every):
        sys.stdout.write(line + "\n")
    return 0 if all(one.same for one in replay(recording)) else 1


if __name__ == "__main__":
    sys.exit(main())
