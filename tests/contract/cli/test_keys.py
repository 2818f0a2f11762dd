"""`atom keys`: what lies in the folder afterwards, and what is said."""

import fcntl
import re
import threading
from pathlib import Path

import httpx
import pytest
from typer.testing import CliRunner, Result

from atom_cli import __main__ as cli
from atom_cli import keys
from contracts.access import CALLERS, CredentialFile, Principal, Role, bus_password_of, sha256_of
from contracts.robot import EmergencyStop, EmergencyStopReply

runner = CliRunner()


def atom(folder: Path, *words: str, typed: str = "") -> Result:
    return runner.invoke(cli.app, ["keys", *words, "--folder", str(folder)], input=typed)


def principals(folder: Path) -> dict[str, Principal]:
    return {one.name: one for one in CredentialFile.model_validate_json((folder / "keys.json").read_bytes()).principals}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "keys"


@pytest.fixture
def made(folder: Path) -> Path:
    assert atom(folder, "make").exit_code == 0
    return folder


def test_one_command_makes_all_that_a_deployment_needs(made: Path) -> None:
    found = principals(made)
    assert set(CALLERS) < set(found)
    assert {name: sha256_of((made / f"{name}.key").read_text().strip()) for name in CALLERS} == {
        name: found[name].key_sha256 for name in CALLERS
    }
    assert found["admin"].role is Role.ADMIN
    acl = (made / "redis.acl").read_text()
    assert all(f"user {name} on #" in acl for name in CALLERS)
    assert sha256_of(bus_password_of((made / "ui.key").read_text().strip())) in acl


def test_only_the_owner_can_read_what_was_made(made: Path) -> None:
    assert made.stat().st_mode & 0o777 == 0o700
    assert {one.stat().st_mode & 0o777 for one in made.iterdir()} == {0o600}


def test_no_key_lies_in_the_file_of_keys_nor_is_printed_but_to_whom_it_belongs(folder: Path) -> None:
    said = atom(folder, "make").output
    kept = (folder / "keys.json").read_text() + (folder / "redis.acl").read_text()
    theirs = [(folder / f"{name}.key").read_text().strip() for name in CALLERS]
    assert not [key for key in theirs if key in said or key in kept]
    (admin,) = re.findall(r"shown this once: (\S{43})\n", said)
    assert principals(folder)["admin"].key_sha256 == sha256_of(admin)
    assert admin not in kept


def test_the_services_keys_alone_come_without_a_person(folder: Path) -> None:
    assert "shown this once" not in atom(folder, "make", "--services").output
    assert "admin" not in principals(folder)


def test_making_again_makes_only_what_is_not_there(made: Path) -> None:
    before = {one.name: one.read_text() for one in made.iterdir()}
    (made / "ui.key").unlink()
    assert "shown this once" not in atom(made, "make").output
    after = {one.name: one.read_text() for one in made.iterdir()}
    assert {name for name in after if after[name] != before[name]} == {"keys.json", "redis.acl", "ui.key"}


def test_a_person_gets_a_key_with_a_role(made: Path) -> None:
    said = atom(made, "make", "anna", "--role", "viewer").output
    (key,) = re.findall(r"anna \(viewer\), shown this once: (\S{43})\n", said)
    assert principals(made)["anna"] == Principal(name="anna", role=Role.VIEWER, key_sha256=sha256_of(key))


def test_a_password_is_kept_as_argon2_and_leaves_role_and_key_as_they_were(made: Path) -> None:
    atom(made, "make", "anna", "--role", "viewer")
    before = principals(made)["anna"]
    typed = "correct horse battery\n" * 2
    assert atom(made, "make", "anna", "--password", typed=typed).exit_code == 0
    after = principals(made)["anna"]
    assert (after.role, after.key_sha256) == (before.role, before.key_sha256)
    assert str(after.password).startswith("$argon2id$")
    assert "correct horse" not in (made / "keys.json").read_text()


@pytest.mark.parametrize(
    ("words", "typed", "why"),
    [
        (("make", "anna"), "", "has a key"),
        (("make", "coordinator"), "", "a service's name"),
        (("make", "prometheus", "--password"), "", "a service's name"),
        (("make", "A b"), "", "pattern"),
        (("make", "bert", "--password"), "short\nshort\n", "10 to 200 characters"),
        (("make", "bert", "--password"), f"{'x' * 201}\n{'x' * 201}\n", "10 to 200 characters"),
        (("revoke", "nobody"), "", "nobody is called"),
        (("make", "bert", "--role", "king"), "", "king"),
    ],
)
def test_what_makes_no_sense_is_refused_and_changes_nothing(
    made: Path, words: tuple[str, ...], typed: str, why: str
) -> None:
    atom(made, "make", "anna")
    before = principals(made)
    result = atom(made, *words, typed=typed)
    assert result.exit_code == 2
    assert why in result.output
    assert principals(made) == before


def test_a_revoked_key_is_gone_with_its_file_and_its_user_at_redis(made: Path) -> None:
    assert atom(made, "revoke", "ui").exit_code == 0
    assert "ui" not in principals(made)
    assert not (made / "ui.key").exists()
    assert "user ui" not in (made / "redis.acl").read_text()


def test_of_two_who_make_keys_at_once_neither_is_lost(made: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    lock, read, waits = fcntl.flock, keys._read, threading.Event()
    other = threading.Thread(target=keys.make, args=("bert",), kwargs={"folder": made})
    at_lock = iter((bool, waits.set))
    after_reading = iter((lambda: (other.start(), waits.wait(10.0)), tuple))

    def lock_and_tell(file: int, how: int) -> None:
        next(at_lock)()
        lock(file, how)

    def read_while_the_other_begins(folder: Path) -> dict[str, Principal]:
        found = read(folder)
        next(after_reading)()
        return found

    monkeypatch.setattr(fcntl, "flock", lock_and_tell)
    monkeypatch.setattr(keys, "_read", read_while_the_other_begins)
    atom(made, "make", "anna")
    other.join(10.0)
    assert {"anna", "bert"} < set(principals(made))


def test_the_list_tells_names_and_roles(made: Path) -> None:
    said = atom(made, "list").output
    assert re.search(r"coordinator\s+service\s+yes\s+-", said)


def test_a_file_that_is_none_is_named(folder: Path) -> None:
    folder.mkdir()
    (folder / "keys.json").write_text("{")
    assert "is no file of keys" in atom(folder, "list").output


@pytest.mark.parametrize("by_file", [True, False])
def test_atom_says_who_asks_by_its_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, by_file: bool) -> None:
    (tmp_path / "my.key").write_text("my own\n")
    monkeypatch.setenv(*(("ATOM_KEY_FILE", str(tmp_path / "my.key")) if by_file else ("ATOM_KEY", "my own")))
    assert said_by(monkeypatch, "resume") == ["Bearer my own"]


def test_a_key_that_cannot_be_read_does_not_hold_up_a_stop(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ATOM_KEY_FILE", "/nowhere/my.key")
    assert said_by(monkeypatch, "stop") == [""]


def said_by(monkeypatch: pytest.MonkeyPatch, order: str) -> list[str]:
    """What `atom stop` or `atom resume` says of who asks."""
    said: list[str] = []

    def answer(request: httpx.Request) -> httpx.Response:
        said.append(request.headers.get("authorization", ""))
        reply = EmergencyStopReply(state=EmergencyStop(latched=True, epoch=1), first_zero_ms=0.8)
        return httpx.Response(200, content=reply.model_dump_json())

    monkeypatch.setattr(cli, "transport", httpx.MockTransport(answer))
    result = runner.invoke(cli.app, [order], input="y\n")
    assert result.exit_code == 0, result.output
    assert "my own" not in result.output
    return said
