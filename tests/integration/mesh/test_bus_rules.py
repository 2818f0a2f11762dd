"""The ACL that `atom keys make` writes, at a real Redis: each service at each topic."""

from collections.abc import Iterator
from pathlib import Path

import pytest
import redis
from pydantic import SecretStr
from redis.exceptions import AuthenticationError, NoPermissionError

from atom_cli import keys
from contracts.access import CALLERS, bus_password_of
from contracts.mission import MissionTarget
from contracts.topics import ALL_TOPICS, MISSION_TARGET, Topic
from mesh.bus import open_bus
from support.redis_server import free_port, start_redis
from support.waiting import until

DOES_BOTH = {"coordinator", "inference", "robot_bridge"}
"""A user's channels are one list (Redis 6.2): these could publish what they only listen to."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("deployment") / "keys"
    keys.make(services=True, folder=made)
    return made


@pytest.fixture(scope="module")
def port(folder: Path) -> Iterator[int]:
    chosen = free_port()
    process = start_redis(chosen, "--aclfile", str(folder / "redis.acl"))
    try:
        yield chosen
    finally:
        process.terminate()
        process.wait(timeout=45)


def as_service(port: int, folder: Path, name: str) -> "redis.Redis":
    password = bus_password_of((folder / f"{name}.key").read_text().strip())
    return redis.Redis(port=port, username=name, password=password)


def permitted(client: "redis.Redis", *words: str) -> bool:
    try:
        client.execute_command(*words)
    except NoPermissionError:
        return False
    return True


def subscribed(client: "redis.Redis", topic: str) -> bool:
    with client.pubsub() as listener:
        listener.subscribe(topic)
        try:
            return listener.get_message(timeout=10.0) is not None
        except NoPermissionError:
            return False


@pytest.mark.parametrize("name", CALLERS)
@pytest.mark.parametrize("topic", ALL_TOPICS, ids=lambda one: one.name)
def test_a_topic_is_open_to_its_publisher_and_its_listeners(
    port: int, folder: Path, name: str, topic: Topic[MissionTarget]
) -> None:
    with as_service(port, folder, name) as client:
        says, hears = topic.publisher == name, name in topic.listeners
        assert permitted(client, "PUBLISH", topic.name, "{}") == (says or (hears and name in DOES_BOTH))
        assert subscribed(client, topic.name) == (hears or (says and name in DOES_BOTH))


@pytest.mark.parametrize("words", ["KEYS *", "FLUSHALL", "CONFIG GET *", "ACL LIST", "EVAL 1 0"])
def test_nobody_may_more_than_that(port: int, folder: Path, words: str) -> None:
    with as_service(port, folder, "coordinator") as client:
        assert not permitted(client, *words.split())


def test_without_a_password_there_is_a_ping_and_nothing_else(port: int) -> None:
    with redis.Redis(port=port) as client:
        assert client.ping()
        assert not permitted(client, "PUBLISH", MISSION_TARGET.name, "{}")
    with redis.Redis(port=port, username="ui", password="guessed") as client, pytest.raises(AuthenticationError):
        client.ping()


async def test_a_services_bus_takes_its_password_from_its_key(port: int, folder: Path) -> None:
    key = SecretStr((folder / "coordinator.key").read_text().strip())
    async with open_bus(f"redis://coordinator@127.0.0.1:{port}/0", key) as bus:
        await until(lambda: bus.connected)
        assert await bus.publish(MISSION_TARGET, MissionTarget(target=None, mission_id="m1"))
        assert (await bus.last(MISSION_TARGET)) == MissionTarget(target=None, mission_id="m1")
