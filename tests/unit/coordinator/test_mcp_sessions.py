"""Who has how many MCP sessions open."""

from coordinator.adapters.mcp_sessions import McpSessions

IDLE_S = 600.0


def opened(sessions: McpSessions, session: str) -> None:
    with sessions.opening("vera") as one:
        sessions.opened(one, session, 0.0)


def test_each_counts_its_own_and_one_that_is_being_opened_counts() -> None:
    sessions = McpSessions(idle_s=IDLE_S)
    opened(sessions, "a")
    with sessions.opening("vera") as second:
        assert (sessions.of("vera", 1.0), sessions.of("otto", 1.0)) == (2, 0)
        sessions.opened(second, "b", 1.0)
        assert sessions.of("vera", 1.0) == 2, "it counts once"
    with sessions.opening("vera"):
        assert sessions.of("vera", 1.0) == 3
    assert sessions.of("vera", 1.0) == 2, "a request that opened none"


def test_one_that_ended_or_was_idle_for_too_long_counts_no_more() -> None:
    sessions = McpSessions(idle_s=IDLE_S)
    opened(sessions, "a")
    opened(sessions, "b")
    sessions.closed("a")
    sessions.closed("never heard of")
    assert (sessions.of("vera", IDLE_S - 1.0), sessions.of("vera", IDLE_S)) == (1, 0)


def test_one_that_is_served_is_not_idle() -> None:
    sessions = McpSessions(idle_s=IDLE_S)
    opened(sessions, "a")
    sessions.begin_request("a")
    assert sessions.of("vera", 2.0 * IDLE_S) == 1
    sessions.end_request("a", 2.0 * IDLE_S)
    assert (sessions.of("vera", 2.9 * IDLE_S), sessions.of("vera", 3.0 * IDLE_S)) == (1, 0)
