"""When a message was taken: stamps of every kind of clock."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot_bridge.sensing.stamps import APART_S_MAX, BASE, LATE_S_MAX, THIS_COMPUTER, Clocks

NOW_S = 1_700_000_000.0


def run(clocks: Clocks, behind_s: dict[str, float], *, beats: int = 30, from_s: float = NOW_S) -> float:
    """All of them send at 10 Hz, each on its own clock; the time of the last."""
    for beat in range(beats):
        for sensor, late_s in behind_s.items():
            clocks.moment(sensor, from_s + beat * 0.1 - late_s, from_s + beat * 0.1)
    return from_s + (beats - 1) * 0.1


def test_clocks_that_agree_are_not_named_and_amcl_may_date_ahead() -> None:
    clocks = Clocks()
    now_s = run(clocks, {BASE: 0.02, "scan": 0.1, "rgb": 0.3, "depth": 0.2, "tf": -1.0})
    assert clocks.odd(now_s) == {}


@pytest.mark.parametrize("odd", [BASE, "scan", "rgb", "depth", "tf"])
@pytest.mark.parametrize("behind_s", [3.0, -3.0, 3600.0, -3600.0, NOW_S - 500.0])
def test_the_odd_clock_is_named_whichever_it_is(odd: str, behind_s: float) -> None:
    clocks = Clocks()
    now_s = run(clocks, {BASE: 0.0, "scan": 0.0, "rgb": 0.0, "depth": 0.0, "tf": 0.0} | {odd: behind_s})
    assert clocks.odd(now_s) == {odd: pytest.approx(behind_s)}


def test_where_the_whole_robot_disagrees_this_computer_is_the_odd_one_unless_its_time_is_simulated() -> None:
    clocks = Clocks()
    now_s = run(clocks, {BASE: 3600.0, "scan": 3600.0, "rgb": 3600.0})
    assert clocks.odd(now_s) == {THIS_COMPUTER: pytest.approx(-3600.0)}
    clocks.simulated = True
    assert clocks.odd(now_s) == {}


def test_who_has_fallen_silent_is_not_compared() -> None:
    clocks = Clocks()
    now_s = run(clocks, {BASE: 0.0, "rgb": 3600.0})
    assert set(clocks.odd(now_s)) == {"rgb"}
    assert clocks.odd(now_s + 60.0) == {}


@given(st.floats(-1e9, 1.6e9), st.floats(0.0, 0.4))
def test_a_picture_is_put_where_the_robot_was_when_it_was_taken_whatever_the_robots_clock_says(
    clock_s: float, under_way_s: float
) -> None:
    """Base and camera share a clock; the picture is longer under way than odometry."""
    clocks = Clocks()
    now_s = run(clocks, {BASE: clock_s, "rgb": clock_s + under_way_s}) + 0.1
    base = clocks.moment(BASE, now_s - clock_s, now_s)
    picture = clocks.moment("rgb", now_s - clock_s - under_way_s, now_s)
    assert base is not None
    assert picture is not None
    assert base.stamp_s - picture.stamp_s == pytest.approx(under_way_s, abs=1e-3)


@given(st.lists(st.tuples(st.sampled_from([BASE, "scan", "rgb", "tf"]), st.floats(-1e10, 1e10)), max_size=60))
def test_no_stamp_puts_a_message_far_from_its_arrival(sent: list[tuple[str, float]]) -> None:
    clocks = Clocks()
    for number, (sensor, stamp_s) in enumerate(sent):
        now_s = NOW_S + number * 0.1
        moment = clocks.moment(sensor, stamp_s, now_s)
        assert moment is None or -2.0 - 1e-3 <= now_s - moment.stamp_s <= LATE_S_MAX + 1e-3


@given(st.lists(st.floats(0.01, 1e10), min_size=1, max_size=30))
def test_only_the_very_stamp_of_the_last_is_no_news(stamps_s: list[float]) -> None:
    clocks = Clocks()
    before = None
    for number, stamp_s in enumerate(stamps_s):
        moment = clocks.moment("rgb", stamp_s, NOW_S + number * 0.1)
        assert (moment is None) == (stamp_s == before)
        before = stamp_s


@given(st.floats(0.01, 1e5), st.booleans())
def test_a_stream_whose_clock_is_set_goes_on_within_a_second(step_s: float, back: bool) -> None:
    clocks = Clocks()
    run(clocks, {BASE: 0.0, "rgb": 0.0})
    after = step_s if back else -step_s
    now_s = run(clocks, {BASE: after, "rgb": after}, beats=15, from_s=NOW_S + 3.0) + 0.1
    moment = clocks.moment("rgb", now_s - after, now_s)
    assert moment is not None
    assert abs(now_s - moment.stamp_s) <= APART_S_MAX
