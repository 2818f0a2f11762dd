"""A writer killed at any instant has lost nothing that it acknowledged."""

from pathlib import Path

from bench.memory_kills import campaign


def test_nothing_that_was_acknowledged_is_lost_when_the_writer_is_killed_again_and_again(tmp_path: Path) -> None:
    found = campaign(8, 1, tmp_path)
    assert found["lost"] == found["files_set_aside"] == 0
    assert found["acknowledged"] >= 8
