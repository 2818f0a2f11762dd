"""Writes anew what services ask of each other, where it has changed: part of `make api`."""

import asyncio
import json
import tempfile
from pathlib import Path
from typing import Any

from api_consumers import PLACE, examples

from support.consumer_link import Ids, Recorded, lacking
from support.consumer_providers import provider
from support.consumer_scripts import SCRIPTS


async def recorded(consumer: str, asked: str) -> list[dict[str, Any]]:
    """The script's exchanges with the running provider."""
    with tempfile.TemporaryDirectory() as folder:
        async with provider(asked, Path(folder)) as service:
            line = Recorded(consumer, service)
            await SCRIPTS[consumer, asked](line)
            return line.exchanged


def is_as_committed(consumer: str, asked: str, found: list[dict[str, Any]]) -> bool:
    """The same requests, and answers of the same shape: stamps and ids alone are no change."""
    if not (PLACE / f"{consumer}.{asked}.json").exists():
        return False
    committed, ids = examples(consumer, asked), Ids()
    for one, other in zip(committed, found, strict=False):
        if ids.put_in(one.request) != other["request"] or one.answer["status"] != other["answer"]["status"]:
            return False
        if [*lacking(one.answer, other["answer"]), *lacking(other["answer"], one.answer)]:
            return False
        ids.learn(one.answer, other["answer"])
    return len(committed) == len(found)


async def main() -> None:
    PLACE.mkdir(parents=True, exist_ok=True)
    for consumer, asked in SCRIPTS:
        found = await recorded(consumer, asked)
        if not is_as_committed(consumer, asked, found):
            text = json.dumps(found, indent=1, ensure_ascii=False)
            (PLACE / f"{consumer}.{asked}.json").write_text(f"{text}\n", encoding="utf-8")


if __name__ == "__main__":
    asyncio.run(main())
