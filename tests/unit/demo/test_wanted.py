import pytest

from demo.scenario import wanted_in
from sim.home import Home, Wanted


@pytest.mark.parametrize(
    ("command", "wanted"),
    [
        ("find the red bottle", Wanted("bottle", "red")),
        ("Where is the green bottle?", Wanted("bottle", "green")),
        ("bring me the teddy bear", Wanted("teddy bear", None)),
        ("bring me the brown teddy", Wanted("teddy bear", "brown")),
        ("find the orange cup", Wanted("cup", "orange")),
        ("find an orange", Wanted("orange", None)),
        ("find the red clock", Wanted("clock", None)),
        ("find my keys", None),
        ("", None),
    ],
)
def test_the_home_is_asked_to_hold_what_the_command_names(command: str, wanted: Wanted | None) -> None:
    assert wanted_in(command) == wanted


def test_such_a_home_can_be_made() -> None:
    home = Home.generate(5, wanted=wanted_in("find the blue cup"))
    assert [thing.colour for thing in home.things if thing.kind == "cup"].count("blue") == 1
