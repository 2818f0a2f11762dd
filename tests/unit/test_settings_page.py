"""docs/settings.md holds every setting, as the classes have it."""

import pytest
import settings_page


def test_the_page_is_as_the_classes_are() -> None:
    assert settings_page.PAGE.read_text(encoding="utf-8") == settings_page.page(), "run tools/settings_page.py"


@pytest.mark.parametrize("service", ["coordinator", "inference", "memory", "robot_bridge", "speech", "ui", "ear"])
def test_every_setting_says_what_it_is_for(service: str) -> None:
    found = settings_page.variables(settings_page.settings_of(service))
    assert [name for name, field, _ in found if not field.description] == []
