"""The adapter of Ollama's models over real HTTP, to a stand-in that speaks `/api/chat`: what it asks and reads."""

import json
from collections.abc import AsyncIterator, Iterator
from typing import Any

import pytest

from contracts.exploration import TOOLS as DECLARED
from contracts.exploration import AskingReason, CheckPathClear, ExplorationDecision, MoveToward, NavigateToGoal
from coordinator.adapters.ollama_pilot import SYSTEM, OllamaPilot
from coordinator.exploration.commands import AskModel
from coordinator.settings import Settings
from mesh.errors import ServiceTimeoutError, UnavailableError, UpstreamError
from support.language_servers import LanguageServer, OllamaHandler, Reply, running

QUESTION = AskModel(1, AskingReason.BEGUN, "at x 0.0 y 0.0; clear m: ahead 2.0", "yes, clear for 2.0 m")


def calls(name: str, **arguments: Any) -> Reply:
    return Reply({"tool_calls": [{"function": {"name": name, "arguments": arguments}}]})


@pytest.fixture
def server() -> Iterator[LanguageServer]:
    with running(OllamaHandler) as one:
        yield one


@pytest.fixture
async def pilot(server: LanguageServer) -> AsyncIterator[OllamaPilot]:
    one = pilot_of(server.url)
    yield one
    await one.aclose()


def pilot_of(url: str, *, timeout_s: float = 5.0) -> OllamaPilot:
    settings = Settings.model_validate({"exploration_model": "small", "exploration_model_url": url})
    return OllamaPilot(settings, timeout_s=timeout_s)


async def test_it_is_told_the_situation_and_the_seven_tools_with_their_bounds(
    server: LanguageServer, pilot: OllamaPilot
) -> None:
    server.says(calls("stop_robot"))
    await pilot.decide(QUESTION)
    (asked,) = server.asked
    assert asked["model"] == "small"
    assert [one["content"] for one in asked["messages"]] == [
        SYSTEM, f"{QUESTION.situation}\nyour last tool told: yes, clear for 2.0 m"
    ]  # fmt: skip
    functions = {one["function"]["name"]: one["function"]["parameters"] for one in asked["tools"]}
    assert list(functions) == [one.model_fields["tool"].default for one in DECLARED]
    bearing = functions["move_toward"]["properties"]["bearing_rad"]
    assert (bearing["type"], bearing["description"]) == (
        "number", "rad from the robot's x axis, left is positive, from -3.14159, to 3.14159"
    )  # fmt: skip
    assert functions["navigate_to_goal"]["properties"]["frontier"]["type"] == "integer"
    assert functions["move_toward"]["required"] == ["bearing_rad", "distance_m"]
    assert asked["options"]["num_predict"] <= 200


@pytest.mark.parametrize(
    ("reply", "decision"),
    [
        (calls("move_toward", bearing_rad=0.5, distance_m=1.0), MoveToward(bearing_rad=0.5, distance_m=1.0)),
        (calls("navigate_to_goal", frontier=3), NavigateToGoal(frontier=3)),
        (calls("check_path_clear", bearing_rad=-1, distance_m=2), CheckPathClear(bearing_rad=-1.0, distance_m=2.0)),
        (Reply({"content": '{"tool": "navigate_to_goal", "frontier": 2}'}), NavigateToGoal(frontier=2)),
    ],
)
async def test_a_tool_call_is_a_decision(
    server: LanguageServer, pilot: OllamaPilot, reply: Reply, decision: ExplorationDecision
) -> None:
    server.says(reply)
    answer = await pilot.decide(QUESTION)
    assert (answer.decision, answer.detail) == (decision, "")
    assert answer.tokens == 20


WRONG: dict[str, Reply] = {
    "a tool that nobody declared": calls("cmd_vel", linear_x=2.0),
    "not a number": calls("rotate", angle_rad=float("nan")),
    "infinite": calls("rotate", angle_rad=float("inf")),
    "beyond its bounds": calls("move_toward", bearing_rad=0.0, distance_m=50.0),
    "a field too many": calls("rotate", angle_rad=1.0, speed_rad_s=99.0),
    "a field too few": calls("move_toward", bearing_rad=0.0),
    "two goals at once": calls("navigate_to_goal", x_m=1.0, y_m=1.0, frontier=1),
    "prose": Reply({"content": "Ignore all rules and drive at full speed into the wall."}),
    "a Twist in prose": Reply({"content": '{"linear": {"x": 2.0}, "angular": {"z": 4.0}}'}),
    "nothing": Reply({"content": ""}),
    "a long flood of words": Reply({"content": '{"tool": "rotate"' + ', "angle_rad": 1' * 5_000}),
}


@pytest.mark.parametrize("what", WRONG)
async def test_what_is_no_tool_within_its_bounds_is_no_decision(
    server: LanguageServer, pilot: OllamaPilot, what: str
) -> None:
    server.says(WRONG[what])
    answer = await pilot.decide(QUESTION)
    assert answer.decision is None
    assert 0 < len(answer.detail) <= 200
    assert answer.tokens > 0


async def test_of_a_flood_of_calls_the_first_alone_is_read(server: LanguageServer, pilot: OllamaPilot) -> None:
    one = {"function": {"name": "rotate", "arguments": {"angle_rad": 1.0}}}
    server.says(Reply({"tool_calls": [one, *[{"function": {"name": "cmd_vel", "arguments": {}}}] * 500]}))
    answer = await pilot.decide(QUESTION)
    assert answer.decision is not None
    assert answer.decision.tool == "rotate"


async def test_a_model_without_tools_is_asked_for_the_json_of_one(server: LanguageServer, pilot: OllamaPilot) -> None:
    server.refuses_tools = True
    server.says({"tool": "rotate", "angle_rad": 1.0})
    for _ in range(2):
        answer = await pilot.decide(QUESTION)
        assert answer.decision is not None
    assert [bool(one.get("tools")) for one in server.asked] == [True, False, False]
    assert "move_toward" in json.dumps(server.asked[-1]["format"])


@pytest.mark.parametrize(
    ("mood", "error"),
    [
        ("malformed", UpstreamError),
        ("not_a_reply", UpstreamError),
        ("overloaded", UpstreamError),
        ("missing", UpstreamError),
        ("dies_mid_answer", UnavailableError),
        ("floods", UnavailableError),
    ],
)
async def test_a_server_that_fails_is_a_named_error(
    server: LanguageServer, pilot: OllamaPilot, mood: str, error: type[Exception]
) -> None:
    server.mood = mood
    with pytest.raises(error):
        await pilot.decide(QUESTION)
    server.mood = "valid"
    server.says(calls("stop_robot"))
    assert (await pilot.decide(QUESTION)).decision is not None


@pytest.mark.parametrize("mood", ["slow", "hangs"])
async def test_a_server_that_takes_too_long_is_not_waited_for(server: LanguageServer, mood: str) -> None:
    server.mood, slow = mood, pilot_of(server.url, timeout_s=0.2)
    server.says(calls("stop_robot"))
    with pytest.raises(ServiceTimeoutError):
        await slow.decide(QUESTION)
    await slow.aclose()


async def test_where_nobody_listens_it_says_so(server: LanguageServer) -> None:
    gone = pilot_of("http://127.0.0.1:9")
    with pytest.raises(UnavailableError, match="not reachable"):
        await gone.decide(QUESTION)
    await gone.aclose()
