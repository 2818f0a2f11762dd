"""The thread that ticks the wheels."""

import threading
import time

import pytest

from robot_bridge.adapters.ros.velocity import Ticker

LONG_S = 60.0


def test_it_ticks_until_it_is_stopped() -> None:
    enough, ticks = threading.Event(), list[int]()

    def tick() -> None:
        ticks.append(1)
        if len(ticks) == 5:
            enough.set()

    ticker = Ticker(tick, period_s=0.01, on_death=pytest.fail)
    ticker.start()
    assert enough.wait(LONG_S)
    ticker.stop()
    ended_at = len(ticks)
    ticker.stop()
    assert len(ticks) == ended_at


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_tick_that_fails_ends_the_process() -> None:
    """A motion loop that is dead behind a healthy /health would be the worst of all."""
    died = threading.Event()

    def tick() -> None:
        raise RuntimeError("broken")

    ticker = Ticker(tick, period_s=0.01, on_death=died.set)
    ticker.start()
    assert died.wait(LONG_S)
    ticker.stop()


def test_beats_missed_are_left_out() -> None:
    """After a tick that took a hundred periods there is no burst of a hundred."""
    blocked, enough = threading.Event(), threading.Event()
    moments = list[float]()

    def tick() -> None:
        moments.append(time.monotonic())
        if len(moments) == 1:
            blocked.wait(LONG_S)
        if len(moments) == 4:
            enough.set()

    ticker = Ticker(tick, period_s=0.05, on_death=pytest.fail)
    ticker.start()
    threading.Timer(1.0, blocked.set).start()
    assert enough.wait(LONG_S)
    ticker.stop()
    resumed = moments[1:4]
    assert resumed[2] - resumed[0] > 0.05, "two whole periods lie between three ticks"
