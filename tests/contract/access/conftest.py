"""Every service's app is made here, the page's too, whichever test ran before."""

import pytest

from support.ui_world import fresh_nicegui


@pytest.fixture(scope="module", autouse=True)
def nicegui_has_not_served() -> None:
    fresh_nicegui()
