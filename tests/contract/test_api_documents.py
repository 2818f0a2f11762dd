"""The documents in docs/api are what the services say, and a change that breaks somebody is told."""

import copy

import pytest
from api_changes import changes
from api_documents import SERVICES, committed, differences, openapi, text_of

from support.ui_world import fresh_nicegui


@pytest.mark.parametrize("service", SERVICES)
def test_the_committed_document_is_the_services_own(service: str) -> None:
    fresh_nicegui()
    document = openapi(service)
    assert differences(service, document) == ([], []), "`make api` writes it"
    assert text_of(document) == text_of(committed(service))


@pytest.mark.parametrize("service", SERVICES)
def test_a_document_breaks_nothing_of_itself(service: str) -> None:
    assert changes(committed(service), committed(service)) == []


def test_a_change_that_breaks_somebody_says_whom() -> None:
    document = copy.deepcopy(committed("memory"))
    del document["components"]["schemas"]["RememberedObject"]["properties"]["belief"]
    del document["paths"]["/statistics"]
    breaking, besides = differences("memory", document)
    assert breaking == [
        "memory: GET /objects no longer always answers `[].belief`. It breaks cli, coordinator, ui.",
        "memory: GET /objects/{number} no longer always answers `belief`. "
        "It breaks no service of ours, perhaps somebody's script.",
        "memory: POST /recall no longer always answers `views[].thing.belief`. It breaks coordinator.",
        "memory: GET /statistics is gone. It breaks no service of ours, perhaps somebody's script.",
    ]
    assert besides == []
