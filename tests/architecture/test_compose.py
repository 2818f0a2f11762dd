"""compose.yaml as Docker Compose itself reads it: what every container may use, and who reaches it."""

import json
import re
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import yaml

from ear.settings import Settings as EarSettings
from mesh.settings import ClientSettings
from support.source import ROOT, SERVICES

COMPOSE = Path(sys.executable).with_name("docker-compose")
OURS = [*SERVICES, "sim", "ear", "keys"]
WITH_PROFILE = {
    "sim": "sim",
    "speech": "speech",
    "ear": "ear",
    "ollama": "llm",
    "prometheus": "observe",
    "grafana": "observe",
    "jaeger": "observe",
} | {"caddy": "tls"}
ONCE = frozenset({"keys"})
"""Containers that do their work and end."""


@cache
def composed(*files: str, told: tuple[tuple[str, str], ...] = ()) -> dict[str, Any]:
    """Every service of every profile, variables filled in as on a machine with those alone that are `told`."""
    named = [argument for file in files or ("compose.yaml",) for argument in ("-f", file)]
    answer = subprocess.run(
        [COMPOSE, *named, "--env-file", "/dev/null", "--profile", "*", "config", "--format", "json"],
        cwd=ROOT,
        env=dict(told),
        capture_output=True,
        text=True,
        check=True,
    )
    return json.loads(answer.stdout)


def containers() -> list[str]:
    return sorted(composed()["services"])


def of(name: str) -> dict[str, Any]:
    return composed()["services"][name]


def test_the_mesh_starts_by_default_and_the_rest_by_its_profile() -> None:
    profiles = {name: one["profiles"] for name, one in composed()["services"].items() if one.get("profiles")}
    assert profiles == {name: [profile] for name, profile in WITH_PROFILE.items()}
    assert {*SERVICES, "redis", *ONCE} - set(WITH_PROFILE) == set(containers()) - set(WITH_PROFILE)


@pytest.mark.parametrize("name", containers())
def test_every_container_is_kept_small_and_harmless(name: str) -> None:
    one = of(name)
    assert one["read_only"]
    assert one["cap_drop"] == ["ALL"]
    assert one["security_opt"] == ["no-new-privileges:true"]
    assert one["pids_limit"] <= 256
    assert one["cpus"] <= 2, "a machine with two cores would refuse more"
    assert int(one["mem_limit"]) > 0
    assert "privileged" not in one
    assert one["logging"] == {"driver": "json-file", "options": {"max-size": "10m", "max-file": "3"}}


@pytest.mark.parametrize("name", sorted(set(containers()) - {"caddy"}))
def test_what_is_published_is_published_on_this_machine_only(name: str) -> None:
    assert {port["host_ip"] for port in of(name).get("ports", [])} <= {"127.0.0.1"}


@pytest.mark.parametrize("name", containers())
def test_what_has_to_last_lies_in_a_named_volume_and_what_is_shown_is_read_only(name: str) -> None:
    for one in of(name).get("volumes", []):
        assert one["type"] == "volume" or one["read_only"], one
        assert one["type"] == "volume" or Path(one["source"]).is_dir(), "Docker would make it, and own it as root"


@pytest.mark.parametrize("name", containers())
def test_no_secret_stands_in_the_environment(name: str) -> None:
    told = of(name).get("environment", {})
    assert [key for key in told if re.search(r"PASSWORD|SECRET|TOKEN|_KEY$", key)] == []
    assert [value for value in told.values() if re.search(r"://[^/]*:[^/]*@", str(value))] == []


@pytest.mark.parametrize("name", SERVICES)
def test_a_service_waits_for_redis_and_for_nothing_that_waits_for_a_robot(name: str) -> None:
    waits = {other: one["condition"] for other, one in of(name)["depends_on"].items()}
    assert waits.pop("redis") == "service_healthy"
    assert set(waits) <= ONCE
    assert set(waits.values()) <= {"service_completed_successfully"}


@pytest.mark.parametrize("name", [*SERVICES, "sim"])
def test_sums_take_one_thread_as_in_the_demo(name: str) -> None:
    told = of(name)["environment"]
    assert (told["OMP_NUM_THREADS"], told["OPENBLAS_NUM_THREADS"]) == ("1", "1")


def test_whatever_a_person_may_want_of_the_ear_reaches_its_container() -> None:
    by_compose = {name for name in EarSettings.model_fields if name.endswith(("_url", "_timeout_s"))} | {
        "sound",  # a container hears its microphone: there is no file in it, and no standard input
        *ClientSettings.model_fields,
    }
    names = {f"EAR_{name.upper()}" for name in EarSettings.model_fields if name not in by_compose}
    told = tuple((name, f"said of {name}") for name in sorted(names))
    environment = composed(told=told)["services"]["ear"]["environment"]
    assert {name: environment.get(name) for name in names} == dict(told)


def test_an_ear_of_which_nothing_is_said_is_as_its_settings_say(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in of("ear")["environment"].items():
        if name.startswith("EAR_") and not name.endswith(("_URL", "_KEY_FILE")):
            monkeypatch.setenv(name, value)
    assert EarSettings() == EarSettings.model_construct()


def test_nothing_begins_before_its_keys_are_there() -> None:
    waiting = [name for name, one in composed()["services"].items() if "keys" in one.get("depends_on", {})]
    assert waiting == sorted([*SERVICES, "ear", "redis", "prometheus"])


@pytest.mark.parametrize("name", [*SERVICES, "ear", "redis", "prometheus"])
def test_each_holds_its_own_key_and_nobody_elses(name: str) -> None:
    """All keys lie in a volume that only the container sees that makes them."""
    held = [one["source"] for one in of(name)["volumes"] if one["source"].startswith("keys")]
    assert held == [f"keys-{name.replace('_', '-')}"]
    laid = {one["source"]: one["target"] for one in of("keys")["volumes"]}
    assert laid.pop("keys") == "/keys/all"
    assert laid[held[0]] == f"/keys/{name}"


def test_every_folder_that_keys_are_laid_into_belongs_to_who_lays_them() -> None:
    """One that its image lacks would be root's, and no key could be laid."""
    (made,) = re.findall(r"for one in ([^;]+);", (ROOT / "packages/cli/Dockerfile").read_text(encoding="utf-8"))
    assert {f"/keys/{name}" for name in made.split()} == {one["target"] for one in of("keys")["volumes"]}


def test_only_the_bridge_is_on_the_machines_own_network_and_listens_nowhere_else() -> None:
    assert {name: of(name)["network_mode"] for name in containers() if "network_mode" in of(name)} == {
        "keys": "none",
        "robot_bridge": "host",
    }
    gateway = composed()["networks"]["default"]["ipam"]["config"][0]["gateway"]
    assert of("robot_bridge")["environment"]["ROBOT_BRIDGE_HOST"] == f"127.0.0.1,{gateway}"
    callers = [name for name in containers() if "http://robot_bridge:8004" in of(name).get("environment", {}).values()]
    assert callers == ["coordinator", "ear", "inference", "memory", "ui"]
    assert all(of(name)["extra_hosts"] == [f"robot_bridge={gateway}"] for name in callers)


@pytest.mark.parametrize("name", sorted(set(containers()) - set(OURS)))
def test_an_image_of_others_names_its_version_and_can_be_pinned_to_a_digest(name: str) -> None:
    assert re.search(r":v?\d[\w.-]*$", of(name)["image"])
    assert f"${{ATOM_{name.upper()}_IMAGE:-" in (ROOT / "compose.yaml").read_text(encoding="utf-8")


@pytest.mark.parametrize("project", [*(f"services/{name}" for name in SERVICES), "sim"])
def test_an_image_is_healthy_when_its_service_is_ready(project: str) -> None:
    image = (ROOT / project / "Dockerfile").read_text(encoding="utf-8")
    (port,) = re.findall(r"^EXPOSE (\d+)$", image, re.MULTILINE)
    (asked,) = re.findall(r"HTTPConnection\('127\.0\.0\.1', (\d+), .*'GET', '([^']+)'", image)
    assert asked == (port, "/ready")
    assert len(re.findall(r"^FROM ", image, re.MULTILINE)) == 2, "what builds it stays behind"
    assert re.findall(r"^USER (\S+)$", image, re.MULTILINE)[-1].split(":")[0].isdigit()


def test_the_simulated_robot_and_the_bridge_compile_their_interfaces_once() -> None:
    """Docker takes layers of the same words from its cache."""
    begun = [
        (ROOT / project / "Dockerfile")
        .read_text(encoding="utf-8")
        .partition("ARG BASE=")[2]
        .partition("\nRUN mkdir /wheels")
        for project in ("services/robot_bridge", "sim")
    ]
    assert begun[0][0] == begun[1][0] != ""
    assert begun[0][2].splitlines()[0] == begun[1][2].splitlines()[0]


@pytest.mark.parametrize("profile", ["services/robot_bridge/fastdds.xml", "packages/mesh/src/mesh/fastdds.xml"])
def test_pictures_that_come_in_one_burst_fit_what_udp_receives_into(profile: str) -> None:
    """The system's own 208 KiB hold not one: best effort asks for none of the lost again."""
    sizes = re.findall(r"<receiveBufferSize>(\d+)<", (ROOT / profile).read_text(encoding="utf-8"))
    assert [int(size) >= 4 * 640 * 400 * 3 for size in sizes] == [True]


def test_with_a_gpu_the_language_model_has_it() -> None:
    added = yaml.safe_load((ROOT / "compose.cuda.yaml").read_text(encoding="utf-8"))["services"]
    both = composed("compose.yaml", "compose.cuda.yaml")["services"]
    assert set(both) == set(containers())
    for name in added:
        (device,) = both[name]["deploy"]["resources"]["reservations"]["devices"]
        assert device["driver"] == "nvidia"
