"""Memory over a home in which things are carried about: each chapter's recall is right."""

from pathlib import Path

from bench.memory_story import told


async def test_recall_follows_a_bottle_that_is_hidden_moved_lost_found_and_removed(tmp_path: Path) -> None:
    # not home 0: once the bottle is gone other boxes cover its place from both sides, and memory concludes nothing
    chapters = await told(tmp_path, seed=1)
    assert [(one.happened, one.recalled) for one in chapters] == [(one.happened, one.wanted) for one in chapters]
    assert len(chapters) == 10
