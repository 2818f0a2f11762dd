"""Puts Python packages into an environment: by uv where it can be had, else by pip. Both read pip's configuration."""

import ast
import os
import shutil
import subprocess
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

CHOICE = "ATOM_INSTALLER"
"""Environment variable: `pip` does without uv."""
UV_REQUIREMENT = "uv>=0.8,<1"


@dataclass(frozen=True)
class Installer:
    """`install(...)` takes pip's arguments. `environment` lets a child process use the same installer and settings."""

    name: str
    command: tuple[str, ...]
    environment: Mapping[str, str]

    def install(self, *arguments: str) -> int:
        """The exit status."""
        return subprocess.run(
            [*self.command, *arguments], env={**os.environ, **self.environment}, check=False
        ).returncode


def find_installer(python: Path, say: Callable[[str], None]) -> Installer:
    """uv from the path or from the package index; pip where neither gives it, or where `ATOM_INSTALLER=pip` says so."""
    pip = (str(python), "-m", "pip", "--disable-pip-version-check", "install", "-q")
    by_pip = Installer("pip", pip, {})
    if os.environ.get(CHOICE, "") == "pip":
        return by_pip
    uv = shutil.which("uv") or _fetched_uv(python, pip)
    if uv is None:
        say("uv could not be had: pip takes its place (slower)")
        return by_pip
    listed = subprocess.run([str(python), "-m", "pip", "config", "list"], capture_output=True, text=True, check=False)
    settings = uv_settings(listed.stdout, os.environ)
    return Installer("uv", (uv, "pip", "install", "-q", "--python", str(python)), {**settings, "UV": uv})


def uv_settings(pip_config: str, environment: Mapping[str, str]) -> dict[str, str]:
    """uv's environment variables for what `pip config list` says, so that both look in the same places.

    What uv has been told already stays. Lines are `scope.option='value'`, an `:env:` line wins over a file's.
    """
    options: dict[str, str] = {}
    for line in sorted(pip_config.splitlines(), key=lambda line: line.startswith(":env:")):
        key, found, value = line.partition("=")
        if found:
            options[key.rpartition(".")[2]] = str(ast.literal_eval(value))
    told = {
        "UV_DEFAULT_INDEX": options.get("index-url"),
        "UV_INDEX": options.get("extra-index-url"),
        "UV_FIND_LINKS": ",".join(options["find-links"].split()) if "find-links" in options else None,
        "UV_NO_INDEX": "1" if options.get("no-index") in {"1", "true", "True", "yes"} else None,
        "UV_INSECURE_HOST": options.get("trusted-host"),
        "UV_HTTP_TIMEOUT": options.get("default-timeout") or options.get("timeout"),
        "SSL_CERT_FILE": options.get("cert"),
        # pip takes the best version of all indexes, and so must uv for the same result
        "UV_INDEX_STRATEGY": "unsafe-best-match" if "extra-index-url" in options else None,
    }
    return {name: value for name, value in told.items() if value and name not in environment}


def _fetched_uv(python: Path, pip: tuple[str, ...]) -> str | None:
    uv = python.with_name("uv")
    if not uv.exists():
        subprocess.run([*pip, UV_REQUIREMENT], capture_output=True, check=False)
    return str(uv) if uv.exists() else None
