"""A variable that no service reads is refused at its start: ignored, it would be a setting somebody believes in."""

import re
from pathlib import Path

import pytest
import settings_page

from contracts.mission import MissionState
from demo.stack import Ports, Stack
from mesh.settings import ServiceSettings, refusals

STATES = {state.name for state in MissionState}
ROOT = Path(__file__).parents[3]
SERVICES = pytest.mark.parametrize("service", settings_page.SERVICES)
NAMED_IN = [ROOT / "compose.yaml", ROOT / "Makefile", ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")),
            *sorted(ROOT.glob("services/*/README.md"))]  # fmt: skip


def refused(service: str, monkeypatch: pytest.MonkeyPatch, **variables: str) -> str:
    settings = settings_page.settings_of(service)
    assert issubclass(settings, ServiceSettings)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    with pytest.raises(SystemExit) as exit_:
        settings.read()
    return str(exit_.value.code)


@SERVICES
def test_a_variable_that_is_no_setting_is_refused_and_the_nearest_named(
    service: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    prefix = service.upper()
    said = refused(service, monkeypatch, **{f"{prefix}_REDIS_ULR": "redis://elsewhere"})
    assert (
        said
        == f"{prefix}_REDIS_ULR is no setting: the nearest is {prefix}_REDIS_URL; unset it if it is another program's"
    )


@pytest.mark.parametrize(
    ("old", "new"),
    [("HEADING_KP", "GAINS__HEADING_KP"), ("BLOCKED_S_MAX", "GAINS__BLOCKED_S_MAX"), ("SCAN__NAME", "ROS__SCAN__NAME")],
)
def test_a_setting_that_has_moved_is_named_where_it_is_now(old: str, new: str, monkeypatch: pytest.MonkeyPatch) -> None:
    said = refused("robot_bridge", monkeypatch, **{f"ROBOT_BRIDGE_{old}": "1.5"})
    assert said.endswith(f"ROBOT_BRIDGE_{old} is no setting: it is ROBOT_BRIDGE_{new} now")


@pytest.mark.parametrize(
    ("variable", "told"),
    [
        ("DEPTH", "is no setting: the nearest is ROBOT_BRIDGE_"),  # of many topics
        ("LASER_MASKS__FROM_RAD", "is no setting: the nearest is ROBOT_BRIDGE_LASER_MASKS"),
        ("ROS__SCANN__NAME", "is no setting: the nearest is ROBOT_BRIDGE_ROS__SCAN__NAME"),
        ("XYZZY", "is no setting; unset it"),
    ],
)
def test_a_variable_that_names_no_one_setting_is_told_the_nearest_at_most(
    variable: str, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert refused("robot_bridge", monkeypatch, **{f"ROBOT_BRIDGE_{variable}": "1"}).startswith(
        f"ROBOT_BRIDGE_{variable} {told}"
    )


@pytest.mark.parametrize(
    ("value", "fault"), [('{"scann": {"name": "x"}}', "ROS__SCANN"), ('{"scan": {"nam": "x"}}', "ROS__SCAN__NAM")]
)
def test_an_unknown_key_in_a_settings_json_is_refused(value: str, fault: str, monkeypatch: pytest.MonkeyPatch) -> None:
    said = refused("robot_bridge", monkeypatch, ROBOT_BRIDGE_ROS=value)
    assert said == f"ROBOT_BRIDGE_{fault}: Extra inputs are not permitted"


def test_a_value_beyond_its_bounds_is_told_by_its_variable(monkeypatch: pytest.MonkeyPatch) -> None:
    said = refused("robot_bridge", monkeypatch, ROBOT_BRIDGE_GAINS__TURN_TOLERANCE_RAD="-1", ROBOT_BRIDGE_PORT="0")
    assert [line.partition(":")[0] for line in said.splitlines()] == [
        "ROBOT_BRIDGE_PORT", "ROBOT_BRIDGE_GAINS__TURN_TOLERANCE_RAD",
    ]  # fmt: skip


def test_what_systemd_tells_every_service_is_not_memorys(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MEMORY_PRESSURE_WATCH", "/sys/fs/cgroup/memory.pressure")
    assert settings_page.settings_of("memory")().model_dump()["port"] == 8003


@SERVICES
def test_every_variable_that_the_documents_and_compose_name_is_a_setting(service: str) -> None:
    text = "\n".join(path.read_text(encoding="utf-8") for path in NAMED_IN)
    named = {name for name in re.findall(rf"\b{service.upper()}_[A-Z0-9_]*[A-Z0-9]\b", text) if name not in STATES}
    assert refusals(settings_page.settings_of(service), named) == []


@SERVICES
def test_the_demo_tells_a_service_its_settings_alone(service: str, tmp_path: Path) -> None:
    told = Stack(Ports(9000), tmp_path, tmp_path / "home.json", seed=7)._environment(service)
    assert refusals(settings_page.settings_of(service), re.findall(r'([A-Z0-9_]+)="', told)) == []
