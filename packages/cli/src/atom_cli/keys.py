"""`atom keys`: makes, lists and revokes keys in a folder of this machine; services read `keys.json` again themselves.

The folder holds `keys.json` (names, roles, hashes), `redis.acl`, and one `<name>.key` for each service. What a person
gets is printed once and kept nowhere.
"""

import contextlib
import fcntl
import os
import secrets
from collections.abc import Generator
from pathlib import Path
from typing import Annotated, Final

import typer
from pydantic import ValidationError
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from contracts.access import (
    CALLERS,
    PASSWORD_LENGTH_MAX,
    CredentialFile,
    Principal,
    Role,
    bus_password_of,
    sha256_of,
)
from contracts.topics import bus_rules

ROLES: Final = {
    "coordinator": Role.SERVICE,
    "ear": Role.OPERATOR,
    "inference": Role.VIEWER,
    "memory": Role.VIEWER,
    "robot_bridge": Role.VIEWER,
    "speech": Role.VIEWER,
    "ui": Role.SERVICE,
    "prometheus": Role.VIEWER,
}
"""Of those who get a file. Inference and memory only look, the bridge and speech ask nobody: whoever takes one of them
over does not drive the robot by its key."""
ADMIN: Final = "admin"
PASSWORD_LENGTH_MIN: Final = 10

app = typer.Typer(no_args_is_help=True, help="Who may what: keys for services, programs and people.")
console = Console(highlight=False)
Folder = Annotated[Path, typer.Option(envvar="ATOM_KEYS_FOLDER", help="where the keys lie", file_okay=False)]
FOLDER: Final = Path("keys")


@app.command()
def make(
    name: Annotated[
        str | None, typer.Argument(help="who gets a key; none = every service, Redis, and an admin")
    ] = None,
    role: Annotated[Role | None, typer.Option(help="what it is good for; operator, or as it was")] = None,
    services: Annotated[bool, typer.Option("--services", help="without the admin: nothing secret is printed")] = False,
    password: Annotated[bool, typer.Option("--password", help="ask for a password for the page instead")] = False,
    folder: Folder = FOLDER,
) -> None:
    """Makes one key, or everything a deployment needs that is not there yet. Each secret is printed once."""
    if name in ROLES:
        raise typer.BadParameter(f"{name} is a service's name; `atom keys make` without a name makes its key")
    if name is None:
        with _locked(folder):
            _make_all(folder, _read(folder), admin=not services)
        return
    try:
        new = Principal(name=name, role=role or Role.OPERATOR)
    except ValidationError as error:
        raise typer.BadParameter(f"{name!r}: {error.errors()[0]['msg']}") from None
    key = secrets.token_urlsafe(32)
    secret = {"password": _hashed_password()} if password else {"key_sha256": sha256_of(key)}
    with _locked(folder):
        principals = _read(folder)
        old = principals.get(name, new)
        if old.key_sha256 is not None and not password:
            raise typer.BadParameter(f"{name} has a key; `atom keys revoke {name}` first")
        principals[name] = old.model_copy(update=secret | {"role": role or old.role})
        _write(folder, principals)
    if not password:
        _print_once(principals[name], key)


@app.command(name="list")
def show(folder: Folder = FOLDER) -> None:
    """Who holds what. The keys themselves are not known here."""
    table = Table("name", "role", "key", "password", box=None, padding=(0, 2, 0, 0))
    for one in _read(folder).values():
        table.add_row(one.name, one.role.value, _yes(one.key_sha256), _yes(one.password))
    console.print(table)


@app.command()
def revoke(name: Annotated[str, typer.Argument(help="whose key and password end")], folder: Folder = FOLDER) -> None:
    """Ends somebody's key, password and sessions of the page. `atom keys make` makes a service's again."""
    with _locked(folder):
        principals = _read(folder)
        if principals.pop(name, None) is None:
            raise typer.BadParameter(f"nobody is called {name!r}")
        _write(folder, principals)
        (folder / f"{name}.key").unlink(missing_ok=True)
        if name in CALLERS:
            _write_acl(folder)
            console.print(f"{name} needs a new key: `atom keys make`, then restart it and Redis.")
    console.print(f"[bold]revoked[/]  {escape(name)}")


@contextlib.contextmanager
def _locked(folder: Path) -> Generator[None]:
    """From the reading to the writing: of two commands at once, the second would else take back what the first did."""
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    lock = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield
    finally:
        os.close(lock)


def _make_all(folder: Path, principals: dict[str, Principal], *, admin: bool) -> None:
    for name, role in ROLES.items():
        if name not in principals or not (folder / f"{name}.key").is_file():
            key = secrets.token_urlsafe(32)
            _write_secret(folder, f"{name}.key", key + "\n")
            principals[name] = Principal(name=name, role=role, key_sha256=sha256_of(key))
    if admin and ADMIN not in principals:
        key = secrets.token_urlsafe(32)
        principals[ADMIN] = Principal(name=ADMIN, role=Role.ADMIN, key_sha256=sha256_of(key))
        _print_once(principals[ADMIN], key)
    _write(folder, principals)
    _write_acl(folder)
    console.print(
        f"Keys of {len(ROLES)} services, keys.json and redis.acl are in {escape(str(folder))}.", soft_wrap=True
    )


def _write_acl(folder: Path) -> None:
    """A user a service. The default user has no password and may say PING, which is what a health check says."""
    lines = ["user default on nopass resetchannels -@all +ping"]
    for name in CALLERS:
        file = folder / f"{name}.key"
        if file.is_file():
            hashed = sha256_of(bus_password_of(file.read_text(encoding="utf-8").strip()))
            lines.append(f"user {name} on #{hashed} resetchannels -@all {' '.join(bus_rules(name))}")
    _write_secret(folder, "redis.acl", "\n".join(lines) + "\n")


def _read(folder: Path) -> dict[str, Principal]:
    file = folder / "keys.json"
    try:
        principals = CredentialFile.model_validate_json(file.read_bytes()).principals if file.is_file() else ()
    except ValidationError as error:
        raise typer.BadParameter(f"{file} is no file of keys: {error.errors()[0]['msg']}") from None
    return {one.name: one for one in principals}


def _write(folder: Path, principals: dict[str, Principal]) -> None:
    _write_secret(
        folder, "keys.json", CredentialFile(principals=tuple(principals.values())).model_dump_json(indent=1) + "\n"
    )


def _write_secret(folder: Path, name: str, text: str) -> None:
    """For its owner's eyes, and whole or not at all: a service may read it at any time."""
    new = folder / f".{name}.new"
    new.unlink(missing_ok=True)
    with os.fdopen(os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as file:
        file.write(text)
    new.replace(folder / name)


def _hashed_password() -> str:
    from pwdlib import PasswordHash  # here, so that no other command waits for it, `atom stop` least of all

    said: str = typer.prompt("Password for the page", hide_input=True, confirmation_prompt=True)
    if not PASSWORD_LENGTH_MIN <= len(said) <= PASSWORD_LENGTH_MAX:
        raise typer.BadParameter(f"a password has {PASSWORD_LENGTH_MIN} to {PASSWORD_LENGTH_MAX} characters")
    return PasswordHash.recommended().hash(said)


def _print_once(principal: Principal, key: str) -> None:
    console.print(f"[bold]{escape(principal.name)}[/] ({principal.role.value}), shown this once: {key}", soft_wrap=True)


def _yes(value: str | None) -> str:
    return "yes" if value else "-"
