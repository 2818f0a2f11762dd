"""Wheels are built once per source, requirement, Python and platform, and are in the cache whole or not at all."""

import shutil
from pathlib import Path

import pytest
from interface_wheels.cache import cache_root, cached_wheels, fill
from interface_wheels.sources import PACKAGES_DIR, REQUIREMENTS, cache_key


@pytest.fixture
def sources(tmp_path: Path) -> Path:
    """A copy of the definitions and the pinned requirements, to be changed."""
    shutil.copytree(PACKAGES_DIR, tmp_path / "packages")
    shutil.copy(REQUIREMENTS, tmp_path / REQUIREMENTS.name)
    return tmp_path


def key_of(sources: Path, python_tag: str | None = None) -> str:
    return cache_key(sources / "packages", sources / REQUIREMENTS.name, python_tag)


def make_wheel(work_dir: Path) -> Path:
    output = work_dir / "wheels"
    output.mkdir()
    (output / "some.whl").write_text("whole")
    return output


def test_the_key_is_the_same_wherever_the_sources_lie(sources: Path) -> None:
    assert key_of(sources) == cache_key()


def test_the_key_changes_with_one_field_of_one_message(sources: Path) -> None:
    with (sources / "packages/irobot_create_msgs/msg/LedColor.msg").open("a") as file:
        file.write("uint8 white\n")
    assert key_of(sources) != cache_key()


def test_the_key_changes_when_a_file_is_renamed(sources: Path) -> None:
    path = sources / "packages/tf2_msgs/msg/TFMessage.msg"
    path.rename(path.with_name("TfMessage.msg"))
    assert key_of(sources) != cache_key()


def test_the_key_changes_with_a_pinned_requirement(sources: Path) -> None:
    requirements = sources / REQUIREMENTS.name
    requirements.write_text(requirements.read_text().replace("numpy==2.4.6", "numpy==2.4.7"))
    assert key_of(sources) != cache_key()


def test_the_key_changes_with_the_python_version(sources: Path) -> None:
    assert key_of(sources, "cpython-311 linux-x86_64") != key_of(sources, "cpython-312 linux-x86_64")


def test_byte_code_does_not_change_the_key(sources: Path) -> None:
    (sources / "packages/__pycache__").mkdir()
    (sources / "packages/__pycache__/x.pyc").write_bytes(b"x")
    assert key_of(sources) == cache_key()


def test_a_build_happens_once(tmp_path: Path) -> None:
    wheels = fill(tmp_path, "key", make_wheel)
    assert [wheel.read_text() for wheel in wheels] == ["whole"]
    assert fill(tmp_path, "key", lambda _: pytest.fail("built twice")) == wheels


def test_a_build_that_fails_leaves_nothing_and_the_next_one_succeeds(tmp_path: Path) -> None:
    def fail_halfway(work_dir: Path) -> Path:
        make_wheel(work_dir)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fill(tmp_path, "key", fail_halfway)
    assert cached_wheels(tmp_path, "key") == ()
    assert [path.name for path in tmp_path.iterdir()] == [".lock"]
    assert fill(tmp_path, "key", make_wheel)


def test_what_a_killed_build_left_behind_goes_with_the_next_one(tmp_path: Path) -> None:
    leftover = tmp_path / ".build-killed" / "toolchain"
    leftover.mkdir(parents=True)
    fill(tmp_path, "key", make_wheel)
    assert not leftover.exists()


def test_the_cache_lies_where_the_environment_says(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("ATOM_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache_root() == tmp_path / "xdg" / "atom" / "interfaces"
    monkeypatch.setenv("ATOM_CACHE_DIR", str(tmp_path / "own"))
    assert cache_root() == tmp_path / "own" / "interfaces"
