"""The latch and its file."""

from pathlib import Path

from contracts.robot import EmergencyStop
from robot_bridge.safety.emergency_stop import LatchFile, reset, stopped

FRESH = EmergencyStop(latched=False, epoch=0)


def test_a_stop_latches_and_raises_the_epoch_each_time() -> None:
    once = stopped(FRESH, reason="smoke", by="a person", now_s=5.0)
    twice = stopped(once, reason="fire", by="another", now_s=9.0)
    assert (once.latched, once.epoch, once.since_s) == (True, 1, 5.0)
    assert (twice.epoch, twice.since_s, twice.reason, twice.by) == (2, 5.0, "fire", "another")


def test_a_reset_keeps_the_epoch() -> None:
    released = reset(stopped(FRESH, reason="", by="", now_s=5.0), reason="checked", by="a person")
    assert (released.latched, released.epoch, released.since_s) == (False, 1, None)


def test_there_never_was_a_file(tmp_path: Path) -> None:
    assert LatchFile(tmp_path / "new").load(now_s=7.0) == FRESH


def test_what_was_stored_is_loaded(tmp_path: Path) -> None:
    state = stopped(FRESH, reason="smoke", by="a person", now_s=5.0)
    LatchFile(tmp_path / "new").store(state)
    LatchFile(tmp_path / "new").sync()
    assert LatchFile(tmp_path / "new").load(now_s=7.0) == state
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["emergency_stop.json"]


def test_an_unreadable_file_counts_as_latched_with_an_epoch_beyond_any(tmp_path: Path) -> None:
    (tmp_path / "emergency_stop.json").write_bytes(b'{"latched": fal')
    state = LatchFile(tmp_path).load(now_s=1_800_000_000.5)
    assert (state.latched, state.epoch) == (True, 1_800_000_000)
