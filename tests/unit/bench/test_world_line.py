"""Faults between the services of a world: messages and answers late, lost, twice or senseless, and dead services."""

import asyncio
import contextlib
from collections import Counter
from collections.abc import AsyncGenerator

import httpx
import pytest
from fastapi import FastAPI, WebSocket

from bench.world.bus import WorldBus
from bench.world.clock import run_simulated
from bench.world.faults import Faults
from bench.world.line import Line
from bench.world.troubles import CONTROLLER_PATIENCE, RobotTroubles
from bench.world.wire import Served, Wire, living, open_socket, served
from contracts.problem import Health
from contracts.robot import EmergencyStop, GoalStatus
from contracts.topics import ROBOT_EMERGENCY_STOP
from mesh.errors import MeshError, ServiceTimeoutError, UnavailableError, UpstreamError
from mesh.http import ServiceClient

START_S = 1000.0
"""Of the simulated loop."""


def bad(**faults: float) -> Line:
    return Line(Faults(**faults), seed=1, begins_s=START_S)  # type: ignore[arg-type]


async def heard(line: Line, count: int) -> list[tuple[int, float]]:
    """(epoch, s after it was said) of every message that arrived of `count` said at once."""
    bus, arrived, loop = WorldBus(line), list[tuple[int, float]](), asyncio.get_running_loop()

    async def take(message: EmergencyStop) -> None:
        arrived.append((message.epoch, loop.time() - said_s))

    listening = asyncio.create_task(bus.listen(ROBOT_EMERGENCY_STOP, take))
    await asyncio.sleep(0.1)
    said_s = loop.time()
    for number in range(count):
        await bus.publish(ROBOT_EMERGENCY_STOP, EmergencyStop(latched=False, epoch=number))
    await asyncio.sleep(60.0)
    listening.cancel()
    return arrived


def test_a_message_may_be_lost() -> None:
    assert run_simulated(lambda: heard(bad(bus_drop=1.0), 3)) == []
    assert 20 < len(run_simulated(lambda: heard(bad(bus_drop=0.5), 100))) < 80


def test_a_message_may_come_twice() -> None:
    arrived = run_simulated(lambda: heard(bad(bus_duplicate=1.0), 2))
    assert sorted(epoch for epoch, _ in arrived) == [0, 0, 1, 1]


def test_a_message_may_come_late_and_after_a_later_one() -> None:
    arrived = run_simulated(lambda: heard(bad(bus_delay_s_max=2.0), 20))
    assert [epoch for epoch, _ in arrived] != sorted(epoch for epoch, _ in arrived)
    assert 1.0 < max(late_s for _, late_s in arrived) < 2.1


def test_nothing_goes_wrong_before_it_begins() -> None:
    line = Line(Faults(bus_drop=1.0, reply_lost=1.0), begins_s=START_S + 1e6)
    assert sorted(epoch for epoch, _ in run_simulated(lambda: heard(line, 3))) == [0, 1, 2]


def test_the_same_seed_draws_the_same() -> None:
    first, second = (run_simulated(lambda: heard(bad(bus_drop=0.5, bus_delay_s_max=1.0), 30)) for _ in range(2))
    assert first == second


def app(asked: list[str]) -> FastAPI:
    made = FastAPI()

    @made.get("/health")
    async def health() -> Health:
        asked.append("health")
        return Health(service="sample")

    @made.get("/slow")
    async def slow() -> Health:
        await asyncio.sleep(5.0)
        return Health(service="sample")

    @made.websocket("/session")
    async def session(socket: WebSocket) -> None:
        await socket.accept()
        with contextlib.suppress(RuntimeError):
            while (await socket.receive())["type"] != "websocket.disconnect":
                pass
        asked.append("left")

    return made


@contextlib.asynccontextmanager
async def client(to: Served, line: Line) -> AsyncGenerator[ServiceClient]:
    yield ServiceClient("sample", "http://sample", timeout_s=2.0, transport=Wire("caller", to, line))


def called(line: Line) -> list[str]:
    """What the service was asked by one call that went wrong; raises as the call did."""
    asked: list[str] = []

    async def main() -> None:
        async with served("sample", app(asked), Counter()) as sample, client(sample, line) as calling:
            await calling.get("/health", Health)

    with contextlib.suppress(MeshError):
        run_simulated(main)
    return asked


def test_an_answer_may_be_lost_on_the_way_there_or_back() -> None:
    async def main() -> None:
        async with served("sample", app([]), Counter()) as sample, client(sample, bad(reply_lost=1.0)) as calling:
            await calling.get("/health", Health)

    with pytest.raises(ServiceTimeoutError):
        run_simulated(main)
    done = [called(Line(Faults(reply_lost=1.0), seed=seed, begins_s=START_S)) for seed in range(12)]
    assert [] in done
    assert ["health"] in done


def test_an_answer_may_make_no_sense() -> None:
    async def main() -> None:
        async with served("sample", app([]), Counter()) as sample, client(sample, bad(reply_senseless=1.0)) as calling:
            await calling.get("/health", Health)

    with pytest.raises(UpstreamError):
        run_simulated(main)


def test_a_dead_service_refuses_and_its_connections_break() -> None:
    asked: list[str] = []

    async def main() -> list[str]:
        one, seen = Served("sample", app(asked), {}), list[str]()
        async with client(one, Line()) as calling:
            async with living(one):
                assert (await calling.get("/health", Health)).service == "sample"
                waiting = asyncio.create_task(calling.get("/slow", Health, timeout_s=9.0))
                session = open_socket(one, "ws://sample/session")
                socket = await session.__aenter__()
                await asyncio.sleep(1.0)
            with pytest.raises(MeshError):
                await waiting
            with pytest.raises(OSError, match="closed"):
                await socket.recv()
            await session.__aexit__(None, None, None)
            with pytest.raises(UnavailableError):
                await calling.get("/health", Health)
            with pytest.raises(OSError, match="refused"):
                await open_socket(one, "ws://sample/session").__aenter__()
            async with living(one):
                seen.append((await calling.get("/health", Health)).service)
        return seen

    assert run_simulated(main) == ["sample"]
    assert asked == ["health", "left", "health"]


def test_what_a_dead_service_still_says_does_not_arrive() -> None:
    line = Line()

    async def main() -> None:
        async with served("sample", app([]), Counter()) as sample, client(sample, line) as calling:
            line.dead.add("caller")
            await calling.get("/health", Health)

    with pytest.raises(UnavailableError):
        run_simulated(main)


def troubled(**faults: float) -> RobotTroubles:
    return RobotTroubles(Faults(**faults), seed=1, begins_s=START_S)  # type: ignore[arg-type]


def test_nav2_rejects_gives_up_or_claims_too_much_as_often_as_was_asked() -> None:
    assert [troubled(goal_rejected=1.0).rejects(now_s) for now_s in (START_S - 1.0, START_S)] == [False, True]
    assert troubled(path_lie=1.0).hides_path(START_S)
    ends = {name: troubled(**{name: 1.0}).ends_instead(START_S) for name in
            ("goal_aborted_104", "goal_aborted_2xx", "goal_false_success")}  # fmt: skip
    told = {name: (end[1].status, end[1].error_code) for name, end in ends.items() if end is not None}
    assert told["goal_aborted_104"] == (GoalStatus.ABORTED, CONTROLLER_PATIENCE)
    assert told["goal_aborted_2xx"][1] in {202, 207, 208}
    assert told["goal_false_success"] == (GoalStatus.SUCCEEDED, 0)
    assert troubled().ends_instead(START_S) is None
    often = troubled(goal_rejected=0.3)
    assert 60 < sum(often.rejects(START_S) for _ in range(300)) < 120


def test_the_real_transport_errors_are_what_a_client_sees() -> None:
    """The twin: httpx refuses a closed port with the error that the wire raises."""

    async def main() -> None:
        async with httpx.AsyncClient(trust_env=False) as real:
            await real.get("http://127.0.0.1:9/health")

    with pytest.raises(httpx.ConnectError):
        asyncio.run(main())
