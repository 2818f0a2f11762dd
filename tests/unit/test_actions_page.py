"""docs/actions.md holds every declared action, as the declarations have it."""

import actions_page


def test_the_page_is_as_the_declarations_are() -> None:
    assert actions_page.PAGE.read_text(encoding="utf-8") == actions_page.page(), "run tools/actions_page.py"
