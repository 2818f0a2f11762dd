#!/usr/bin/env python3
"""Fetches the models of a real robot: the COCO detector, CLIP ViT-B/32, and Ollama's language models.

    python tools/models.py [--only detector clip ollama] [--mirror http://nas.lan/models] [--into FOLDER]

A download that broke off goes on where it stopped; nothing is kept whose SHA-256 is not the one in tools/models.toml.
What cannot be reached is named at the end, with what to copy where by hand; the exit code is then 1. Run it where
there is internet; everything else of ATOM works without.
"""

import argparse
import hashlib
import os
import sys
import time
import tomllib
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import httpx
import ollama

ROOT = Path(__file__).resolve().parents[1]
MANIFEST = ROOT / "tools" / "models.toml"
CHUNK_BYTES = 1 << 20
TELL_EVERY_S = 0.5
ATTEMPTS = 3
OLLAMA_URL = "http://127.0.0.1:11434"
NO_WEIGHTS = frozenset(("input_resolution", "context_length", "vocab_size"))
"""Numbers that OpenAI keeps among the tensors of its archive."""


class FetchError(Exception):
    """Why a model is not here, in words for a person."""


@dataclass(frozen=True)
class Wanted:
    """One file: where it comes from, what its bytes must add up to, where it belongs."""

    name: str
    what: str
    url: str
    sha256: str
    path: Path
    weights: Path | None = None
    """Where a TorchScript archive's tensors go, as safetensors."""

    @property
    def made(self) -> Path:
        return self.weights or self.path


def main(argv: Sequence[str] | None = None) -> int:
    options = _options(argv)
    table = tomllib.loads(options.manifest.read_text(encoding="utf-8"))
    files = [_wanted(entry, options.into, options.mirror) for entry in table["file"]]
    missing: list[str] = []
    for one in files:
        if one.name in options.only:
            try:
                say(f"{one.made.name}: {fetch(one)}")
            except FetchError as error:
                say(f"{one.made.name}: {error}")
                missing.append(_by_hand(one))
    if "ollama" in options.only:
        for entry in table.get("ollama", []):
            try:
                say(f"{entry['model']}: {pull(options.ollama_url, entry['model'])}")
            except FetchError as error:
                say(f"{entry['model']}: {error}")
                missing.append(_by_hand_ollama(entry))
    if missing:
        say("\nTo be done by hand:\n" + "\n".join(missing))
        return 1
    say(
        "All models are here. Use them with INFERENCE_MODEL_SET=coco"
        + (_use(table) if "ollama" in options.only else "")
    )
    return 0


def fetch(wanted: Wanted) -> str:
    """Leaves the file where it belongs, and says how it came there. Raises `FetchError`."""
    if wanted.weights is not None and wanted.weights.is_file() and not wanted.path.is_file():
        return "already there"
    if wanted.path.is_file() and digest(wanted.path) == wanted.sha256:
        return "already there" + _unpacked(wanted)
    wanted.path.parent.mkdir(parents=True, exist_ok=True)
    part = wanted.path.with_name(wanted.path.name + ".part")
    began_s = time.monotonic()
    _download_in_attempts(wanted, part)
    found = digest(part)
    if found != wanted.sha256:
        part.unlink()
        raise FetchError(f"the server sent something else: its SHA-256 is {found}, not {wanted.sha256}; not kept")
    part.replace(wanted.path)
    return f"fetched in {time.monotonic() - began_s:.0f} s, SHA-256 is right" + _unpacked(wanted)


def _download_in_attempts(wanted: Wanted, part: Path) -> None:
    for attempt in range(1, ATTEMPTS + 1):
        try:
            _download(wanted, part)
        except httpx.HTTPStatusError as error:
            raise FetchError(f"the server said {error.response.status_code} to {wanted.url}") from error
        except httpx.ConnectError as error:
            raise FetchError(f"not reachable: {httpx.URL(wanted.url).host}") from error
        except httpx.HTTPError as error:
            say(f"{wanted.path.name}: broke off ({type(error).__name__})")
            if attempt == ATTEMPTS:
                raise FetchError(f"broke off {ATTEMPTS} times; run this again to go on from there") from error
        else:
            return


def _download(wanted: Wanted, part: Path) -> None:
    have = part.stat().st_size if part.is_file() else 0
    headers = {"range": f"bytes={have}-"} if have else {}
    timeout = httpx.Timeout(60.0, connect=10.0)
    with httpx.stream("GET", wanted.url, headers=headers, timeout=timeout, follow_redirects=True) as response:
        if response.status_code == httpx.codes.REQUESTED_RANGE_NOT_SATISFIABLE:
            return  # all of it is there; the hash will tell
        response.raise_for_status()
        resumed = response.status_code == httpx.codes.PARTIAL_CONTENT
        done = have if resumed else 0
        total = done + int(response.headers.get("content-length", 0))
        with part.open("ab" if resumed else "wb") as file, _progress(wanted.path.name) as tell:
            for chunk in response.iter_bytes(CHUNK_BYTES):
                file.write(chunk)
                done += len(chunk)
                tell.at(done, total)


def _unpacked(wanted: Wanted) -> str:
    """The tensors of a TorchScript archive as safetensors: what open_clip loads without running code of the archive."""
    if wanted.weights is None or wanted.weights.is_file():
        return ""
    import torch
    from safetensors.torch import save_file

    state = torch.jit.load(str(wanted.path), map_location="cpu").state_dict()
    tensors = {name: tensor.clone() for name, tensor in state.items() if name not in NO_WEIGHTS}
    part = wanted.weights.with_name(wanted.weights.name + ".part")
    save_file(tensors, str(part))
    part.replace(wanted.weights)
    return f", {len(tensors)} tensors in {wanted.weights.name}"


def pull(url: str, model: str) -> str:
    """Lets the Ollama server at `url` fetch a model; the server checks the hash of every layer itself."""
    last = ""
    client = ollama.Client(host=url, timeout=httpx.Timeout(600.0, connect=3.0), trust_env=False)
    try:
        with client, _progress(model) as tell:
            for step in client.pull(model, stream=True):
                last = step.status or last
                if step.total:
                    tell.at(step.completed or 0, step.total)
    except ollama.ResponseError as error:
        raise FetchError(f"Ollama says: {error.error}") from error
    except (httpx.HTTPError, ConnectionError) as error:
        raise FetchError(f"no Ollama server at {url}") from error
    if last != "success":
        raise FetchError(f"Ollama stopped at '{last}'")
    return "in Ollama, its layers checked"


def digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


class _Teller:
    """Writes how far a download is, over and over on one line of a terminal, now and then elsewhere."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._every_s = TELL_EVERY_S if sys.stdout.isatty() else 10.0
        self._told_s = time.monotonic()

    def at(self, done: int, total: int) -> None:
        now_s = time.monotonic()
        if now_s - self._told_s < self._every_s and done != total:
            return
        self._told_s = now_s
        share = f"{100 * done / total:3.0f} % of {total / 1e6:.0f} MB" if total else f"{done / 1e6:.0f} MB"
        sys.stdout.write(f"\r{self._name}: {share}" if sys.stdout.isatty() else f"{self._name}: {share}\n")
        sys.stdout.flush()


@contextmanager
def _progress(name: str) -> Generator[_Teller]:
    yield _Teller(name)
    if sys.stdout.isatty():
        sys.stdout.write("\n")


def _wanted(entry: dict[str, str], into: Path, mirror: str) -> Wanted:
    """`mirror` replaces where files come from, never what they must be."""
    url = f"{mirror.rstrip('/')}/{Path(entry['path']).name}" if mirror else entry["url"]
    weights = into / entry["weights"] if "weights" in entry else None
    return Wanted(entry["name"], entry["what"], url, entry["sha256"], into / entry["path"], weights)


def _by_hand(one: Wanted) -> str:
    return (
        f"- {one.what}\n    from  {one.url}\n    to    {one.path}\n    check sha256sum {one.path} gives {one.sha256}\n"
        "    then  run `make models` again"
    )


def _by_hand_ollama(entry: dict[str, str]) -> str:
    return (
        f"- {entry['model']}, {entry['what']}\n"
        f"    where there is internet: ollama pull {entry['model']}\n"
        "    then copy that machine's folder .ollama/models into the same place of the machine that serves it here"
    )


def _use(table: dict[str, list[dict[str, str]]]) -> str:
    names = [entry["model"] for entry in table.get("ollama", [])]
    return f", INFERENCE_OLLAMA_URL and INFERENCE_VLM_MODEL ({', '.join(names)})"


def _options(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    kinds = ["detector", "clip", "ollama"]
    parser.add_argument("--only", nargs="+", choices=kinds, default=kinds)
    parser.add_argument("--mirror", default="", help="a folder on a web server of yours that holds the files")
    parser.add_argument("--into", type=Path, default=ROOT, help="the folder under which models/ is made")
    parser.add_argument("--manifest", type=Path, default=MANIFEST)
    parser.add_argument("--ollama-url", default=os.environ.get("INFERENCE_OLLAMA_URL") or OLLAMA_URL)
    return parser.parse_args(argv)


def say(text: str) -> None:
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
