"""What each service asks of each other is committed: who is asked still answers it, who asks still reads the answer."""

import inspect
from contextlib import AsyncExitStack
from pathlib import Path
from typing import Any

import pytest
from api_consumers import examples, misfits, pairs
from api_documents import committed

from support.consumer_link import SOCKET, Ids, Played, asked, lacking
from support.consumer_providers import provider
from support.consumer_scripts import CLIENTS, SCRIPTS

PAIRS = sorted(SCRIPTS)
NO_ROUTES = {"aclose", "dependency", "drop_session", "wheels", "back_up", "restore", "hold_missions"}
"""What a client has besides; GET /ready, which `dependency` asks for, all services have from one place. A back-up is a
file of bytes: `tests/contract/cli/test_backup.py` plays it against the services themselves."""


def test_the_committed_pairs_are_those_there_are() -> None:
    assert sorted(pairs()) == PAIRS


@pytest.mark.parametrize("client", CLIENTS, ids=lambda client: f"{client.__module__}.{client.__name__}")
def test_every_call_of_a_client_has_an_example(client: type[Any]) -> None:
    calls = {name for name, one in vars(client).items() if inspect.isfunction(one) and not name.startswith("_")}
    assert calls - NO_ROUTES <= {one.call for pair in CLIENTS[client] for one in examples(*pair)}


@pytest.mark.parametrize(("consumer", "provider_name"), PAIRS)
async def test_who_asks_asks_as_committed_and_reads_the_committed_answers(consumer: str, provider_name: str) -> None:
    was = examples(consumer, provider_name)
    line = Played(was)
    await SCRIPTS[consumer, provider_name](line)
    assert [one["request"] for one in line.exchanged] == [one.request for one in was]


@pytest.mark.parametrize(("consumer", "provider_name"), PAIRS)
async def test_who_is_asked_answers_as_committed(consumer: str, provider_name: str, tmp_path: Path) -> None:
    ids, broken = Ids(), list[str]()
    async with AsyncExitStack() as stack:
        service = await stack.enter_async_context(provider(provider_name, tmp_path))
        for one in examples(consumer, provider_name):
            answer = await asked(service, ids.put_in(one.request), until=stack)
            broken += [f"{provider_name} breaks {consumer}.{one.call}: {what}" for what in lacking(one.answer, answer)]
            assert (one.call, answer["status"]) == (one.call, one.answer["status"])
            ids.learn(one.answer, answer)
    assert broken == []


@pytest.mark.parametrize(("consumer", "provider_name"), PAIRS)
def test_every_example_is_as_the_document_says(consumer: str, provider_name: str) -> None:
    document = committed(provider_name)
    asked_by_http = [one for one in examples(consumer, provider_name) if one.request["method"] != SOCKET]
    assert [what for one in asked_by_http for what in misfits(document, one)] == []
