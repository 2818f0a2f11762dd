"""What setting up decides: what is missing, whether it may be installed, and where packages are looked for."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import installer
import pytest
import setup
import system_packages

NEED = system_packages.Need("no thing", ("libthing1", "thing-data"), lambda: False)


def test_nothing_that_this_machine_needs_is_missing() -> None:
    assert system_packages.missing(for_tests=True) == []


def test_what_only_the_tests_need_is_not_asked_of_a_demo(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ATOM_CHROMIUM", "/nowhere/chromium")
    assert system_packages.missing(for_tests=False) == []
    (lacking,) = system_packages.missing(for_tests=True)
    assert lacking.packages == ("chromium",)


@pytest.mark.parametrize(
    ("environment", "rights", "allowed"),
    [
        ({}, {"is_root": True, "has_sudo": False}, True),
        ({}, {"is_root": False, "has_sudo": True}, True),
        ({}, {"is_root": False, "has_sudo": False}, False),
        ({"ATOM_NO_INSTALL": "1"}, {"is_root": True, "has_sudo": False}, False),
        ({"ATOM_NO_INSTALL": "0"}, {"is_root": True, "has_sudo": False}, True),
    ],
)
def test_packages_are_installed_only_with_the_right_to_and_without_a_no(
    environment: dict[str, str], rights: dict[str, bool], allowed: bool
) -> None:
    assert system_packages.may_install(environment, has_apt=True, **rights) is allowed
    assert not system_packages.may_install(environment, has_apt=False, **rights)


def test_a_missing_thing_is_named_with_the_command_that_brings_it() -> None:
    text = system_packages.explain([NEED])
    assert "no thing" in text
    assert "apt-get install -y --no-install-recommends libthing1 thing-data" in text


def test_a_refusal_leaves_the_machine_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ATOM_NO_INSTALL", "1")
    said: list[str] = []
    assert system_packages.bring([NEED], said.append) == [NEED]
    assert said == []


def test_uv_looks_where_pip_was_told_to_look() -> None:
    listed = "\n".join([
        "global.cert='/etc/ssl/own.crt'",
        "global.extra-index-url='file:///mirror/simple file:///more/simple'",
        "global.find-links='/old'",
        ":env:.find-links='/wheels /more-wheels'",
        "install.no-index='true'",
    ])  # fmt: skip
    assert installer.uv_settings(listed, {"SSL_CERT_FILE": "/etc/mine.crt"}) == {
        "UV_INDEX": "file:///mirror/simple file:///more/simple",
        "UV_FIND_LINKS": "/wheels,/more-wheels",
        "UV_NO_INDEX": "1",
        "UV_INDEX_STRATEGY": "unsafe-best-match",
    }
    assert installer.uv_settings("", {}) == {}


def test_pip_can_be_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ATOM_INSTALLER", "pip")
    found = installer.find_installer(Path(sys.executable), print)
    assert found.name == "pip"
    assert found.install("--help") == 0


@pytest.fixture
def environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A checkout in a folder of its own, with an environment that has contracts from there."""
    package = tmp_path / "packages" / "contracts.py"
    package.parent.mkdir()
    package.touch()
    venv = tmp_path / ".venv"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(venv)], check=True)
    next(venv.glob("lib/python3*/site-packages")).joinpath("contracts.pth").write_text(str(package.parent))
    monkeypatch.setattr(setup, "ROOT", tmp_path)
    monkeypatch.setattr(setup, "PYTHON", venv / "bin" / "python")
    return tmp_path


def test_an_environment_of_this_checkout_is_kept(environment: Path) -> None:
    assert setup.environment_is_usable()


def test_an_environment_that_was_filled_for_another_folder_is_not(
    environment: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(setup, "ROOT", environment / "moved")
    assert not setup.environment_is_usable()


def test_an_environment_whose_python_is_gone_is_not(environment: Path) -> None:
    (environment / ".venv" / "bin" / "python").unlink()
    assert not setup.environment_is_usable()
    (environment / ".venv" / "bin" / "python").symlink_to("/nowhere/python3")
    assert not setup.environment_is_usable()
