"""What was not understood is kept until something is, and told to the log now and then."""

from robot_bridge.sensing.reception import REASON_CHARACTERS_MAX, TOLD_AGAIN_S, Reception


def test_the_reason_stays_until_a_message_is_understood() -> None:
    reception = Reception()
    assert reception.refused("scan") is None
    reception.refuse("scan", "its range_max is 0 m", 1.0)
    refused = reception.refused("scan")
    assert refused is not None
    assert (refused.reason, refused.at_s) == ("its range_max is 0 m", 1.0)
    assert reception.why_none("scan", "silent") == "scan is received and not understood: its range_max is 0 m"
    reception.take("scan", "a note")
    assert reception.refused("scan") is None
    assert (reception.note("scan"), reception.why_none("scan", "silent")) == ("a note", "silent")
    reception.take("scan")
    assert reception.note("scan") == ""


def test_a_sensor_that_is_not_understood_fills_one_line_of_the_log_in_half_a_minute() -> None:
    reception = Reception()
    told = [reception.refuse("scan", f"reason {tick}", tick * 0.1) for tick in range(round(TOLD_AGAIN_S * 10) + 1)]
    assert [tick for tick, is_told in enumerate(told) if is_told] == [0, round(TOLD_AGAIN_S * 10)]
    assert reception.refuse("rgb", "another sensor", 0.2)


def test_a_reason_is_never_longer_than_a_line() -> None:
    reception = Reception()
    reception.refuse("rgb", "x" * 10_000, 1.0)
    refused = reception.refused("rgb")
    assert refused is not None
    assert len(refused.reason) == REASON_CHARACTERS_MAX
