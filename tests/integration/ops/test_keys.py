"""What the container `keys` does, without a container: packages/cli/keys.sh with the real `atom keys`."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from support.source import ROOT, SERVICES

FOLDERS = (*SERVICES, "ear", "redis", "prometheus")


@pytest.fixture
def volumes(tmp_path: Path) -> Path:
    for name in ("all", *FOLDERS):
        (tmp_path / name).mkdir()
    return tmp_path


def keys(volumes: Path, *words: str) -> str:
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = os.environ | {"ATOM_KEYS_FOLDER": str(volumes / "all"), "PATH": path}
    command = ["sh", ROOT / "packages/cli/keys.sh", *words]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout


def laid(volumes: Path) -> dict[str, set[str]]:
    return {name: {one.name for one in (volumes / name).iterdir()} for name in FOLDERS}


def test_each_service_gets_its_own_key_and_no_secret_is_told(volumes: Path) -> None:
    told = keys(volumes)
    expected = {name: {"keys.json", f"{name}.key"} for name in SERVICES}
    assert laid(volumes) == expected | {"ear": {"ear.key"}, "redis": {"redis.acl"}, "prometheus": {"prometheus.key"}}
    secrets = [one.read_text().strip() for one in (volumes / "all").glob("*.key")]
    assert len(secrets) == len(SERVICES) + 2  # the ear's and Prometheus'
    assert [one for one in secrets if one in told] == []
    assert "docker compose run --rm keys make" in told


def test_a_second_start_changes_no_key(volumes: Path) -> None:
    keys(volumes)
    before = {one: one.read_bytes() for one in volumes.rglob("*.*")}
    keys(volumes)
    assert {one: one.read_bytes() for one in volumes.rglob("*.*")} == before


def test_a_persons_key_is_shown_once_and_known_to_every_service(volumes: Path) -> None:
    keys(volumes)
    (key,) = re.findall(r"shown this once: (\S+)", keys(volumes, "make", "anna", "--role", "operator"))
    assert all('"anna"' in (volumes / name / "keys.json").read_text() for name in SERVICES)
    assert [one for one in volumes.rglob("*.*") if key in one.read_text()] == []
    keys(volumes, "revoke", "anna")
    assert not any('"anna"' in (volumes / name / "keys.json").read_text() for name in SERVICES)
