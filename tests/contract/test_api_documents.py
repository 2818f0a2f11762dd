"""The documents in docs/api are what the services say, and a change that breaks somebody is told."""

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
