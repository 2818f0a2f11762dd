import asyncio

from mesh.tasks import Tasks
from support.waiting import until


async def test_a_task_that_dies_ends_the_process() -> None:
    ended: list[str] = []

    async def dies() -> None:
        raise RuntimeError("boom")

    async with Tasks(on_death=lambda: ended.append("ended")) as tasks:
        tasks.start("dies", dies())
        await until(lambda: ended == ["ended"])


async def test_a_forever_task_that_returns_ends_the_process_too() -> None:
    ended: list[str] = []
    async with Tasks(on_death=lambda: ended.append("ended")) as tasks:
        tasks.start("returns", asyncio.sleep(0))
        await until(lambda: ended == ["ended"])


async def test_leaving_the_block_cancels_quietly() -> None:
    ended: list[str] = []
    async with Tasks(on_death=lambda: ended.append("ended")) as tasks:
        task = tasks.start("waits", asyncio.Event().wait())
    assert task.cancelled()
    assert ended == []


async def test_a_task_that_may_end_may_end() -> None:
    ended: list[str] = []
    async with Tasks(on_death=lambda: ended.append("ended")) as tasks:
        await tasks.start("once", asyncio.sleep(0), forever=False)
    assert ended == []
