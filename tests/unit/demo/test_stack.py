import configparser
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from demo.ready import parts_of
from demo.stack import SERVICES, SPEECH, Ports, Stack, StackError, inherited


def stack(folder: Path) -> Stack:
    return Stack(Ports(9000), folder, folder / "home.json", seed=7)


@given(st.integers(min_value=1024, max_value=65000))
def test_every_part_has_a_port_of_its_own_and_ros_a_domain_it_can_have(base: int) -> None:
    ports = Ports(base)
    named = [getattr(ports, name) for name in (*SERVICES, SPEECH, "redis", "truth")]
    assert len(set(named)) == len(named)
    assert 1 <= ports.ros_domain_id <= 101


def test_the_usual_ports_are_the_documented_ones() -> None:
    ports = Ports()
    assert [getattr(ports, service) for service in SERVICES] == [8004, 8002, 8003, 8001, 8080]


def test_supervisord_restarts_each_process_and_tells_it_where_the_others_are(tmp_path: Path) -> None:
    config = configparser.RawConfigParser(strict=False)
    config.read_string(stack(tmp_path)._configuration())
    programs = {name.removeprefix("program:") for name in config.sections() if name.startswith("program:")}
    assert programs == {"redis", "sim", *SERVICES}
    for name in programs:
        assert config[f"program:{name}"]["autorestart"] == "true"
    told = config["program:coordinator"]["environment"]
    assert 'COORDINATOR_ROBOT_BRIDGE_URL="http://127.0.0.1:9004"' in told
    assert 'COORDINATOR_REDIS_URL="redis://127.0.0.1:9005/0"' in told


def test_speech_is_started_where_it_is_wanted_like_every_service_and_the_page_alone_is_told_of_it(
    tmp_path: Path,
) -> None:
    without, wanted = configparser.RawConfigParser(strict=False), configparser.RawConfigParser(strict=False)
    without.read_string(stack(tmp_path)._configuration())
    wanted.read_string(replace(stack(tmp_path), speech=True, keys=tmp_path)._configuration())
    assert set(wanted.sections()) - set(without.sections()) == {"program:speech"}
    speech, page = wanted["program:speech"]["environment"], wanted["program:ui"]["environment"]
    assert 'SPEECH_PORT="9007"' in speech
    assert f'SPEECH_KEY_FILE="{tmp_path}/speech.key"' in speech
    assert f'ATOM_TRACES="{tmp_path}/traces"' in speech
    assert 'UI_SPEECH_URL="http://127.0.0.1:9007"' in page
    others = [name for name in wanted.sections() if "SPEECH_URL" in wanted[name].get("environment", "")]
    assert others == ["program:ui"]
    assert "SPEECH" not in without["program:ui"]["environment"]
    assert parts_of(replace(stack(tmp_path), speech=True)) == ("truth", *SERVICES[:-1], "ui", "speech")


def test_the_shells_settings_reach_the_demo_but_its_keys() -> None:
    keys = {"UI_KEY": "x", "COORDINATOR_KEYS_FILE": "k", "MEMORY_KEY_FILE": "k"}
    assert inherited(keys | {"INFERENCE_OLLAMA_URL": "u"}) == {"INFERENCE_OLLAMA_URL": "u"}


def test_nothing_runs_where_nothing_was_started(tmp_path: Path) -> None:
    mesh = stack(tmp_path)
    assert not mesh.running()
    with pytest.raises(OSError, match="No such file"):
        mesh.states()
    mesh.stop()


def test_a_second_mesh_in_the_same_place_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Stack, "running", lambda self: True)
    with pytest.raises(StackError, match="make down PORT_BASE=9000"):
        stack(tmp_path).start()


def test_another_home_begins_with_an_empty_memory_and_an_empty_history(tmp_path: Path) -> None:
    mesh = stack(tmp_path)
    told = mesh._configuration()
    kept = [tmp_path / name for name in ("memory.db", "coordinator.db")]
    assert all(f"{file}" in told for file in kept)
    for name in ("memory.db", "memory.db-wal", "coordinator.db", "coordinator.db-wal", "dock.json", "maps.json"):
        (tmp_path / name).write_text("of the home before")
    (tmp_path / "logs").mkdir()
    mesh.forget()
    assert [file.name for file in tmp_path.iterdir()] == ["logs"]
