"""`make models` against a web server and an Ollama of our own: what it keeps, what it refuses, what it says."""

import hashlib
import importlib.util
import json
import sys
import threading
import tomllib
from collections.abc import Iterator
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
import torch
from safetensors.torch import load_file

ROOT = Path(__file__).parents[3]
WEIGHTS = bytes(range(256)) * 20_000


@pytest.fixture(scope="module")
def tool() -> ModuleType:
    spec = importlib.util.spec_from_file_location("models_tool", ROOT / "tools" / "models.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


class Server(ThreadingHTTPServer):
    """Serves `files` with ranges; breaks the first `breaks` answers off in the middle; is an Ollama as well."""

    daemon_threads = True

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), Handler)
        self.files: dict[str, bytes] = {}
        self.breaks = 0
        self.ranges: list[str | None] = []
        self.pulled: list[str] = []
        self.pull_steps: list[dict[str, Any]] = []

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server_port}"


class Handler(BaseHTTPRequestHandler):
    server: Server
    protocol_version = "HTTP/1.1"

    def log_message(self, format: str, *args: Any) -> None:
        return

    def do_GET(self) -> None:
        data = self.server.files.get(self.path.rpartition("/")[2])
        if data is None:
            self.answer(404, b"")
            return
        asked = self.headers.get("Range")
        self.server.ranges.append(asked)
        start = int(asked.removeprefix("bytes=").rstrip("-")) if asked else 0
        if start >= len(data):
            self.answer(416, b"")
        else:
            self.answer(206 if asked else 200, data[start:])

    def do_POST(self) -> None:
        body = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        self.server.pulled.append(body["model"])
        self.answer(200, b"".join(json.dumps(step).encode() + b"\n" for step in self.server.pull_steps))

    def answer(self, status: int, data: bytes) -> None:
        self.send_response(status)
        self.send_header("Content-Length", str(len(data)))
        self.end_headers()
        with suppress(BrokenPipeError, ConnectionResetError):
            if self.server.breaks > 0 and data:
                self.server.breaks -= 1
                self.wfile.write(data[: len(data) // 2])
                self.close_connection = True
            else:
                self.wfile.write(data)


@pytest.fixture
def server() -> Iterator[Server]:
    with Server() as running:
        thread = threading.Thread(target=running.serve_forever, kwargs={"poll_interval": 0.02})
        thread.start()
        yield running
        running.shutdown()
        thread.join(30.0)


def manifest(folder: Path, server: Server, data: bytes = WEIGHTS, **more: str) -> list[str]:
    """A table of one detector file, and the arguments that use it."""
    server.files.setdefault("yolo.pt", data)
    entry = {"name": "detector", "what": "a detector", "url": f"{server.url}/yolo.pt", "path": "models/yolo.pt"}
    entry |= {"sha256": hashlib.sha256(data).hexdigest()} | more
    lines = ["[[file]]", *(f'{key} = "{value}"' for key, value in entry.items())]
    (folder / "table.toml").write_text("\n".join(lines), encoding="utf-8")
    return ["--manifest", str(folder / "table.toml"), "--into", str(folder), "--only", "detector"]


def test_a_file_is_fetched_checked_and_not_fetched_again(
    tool: ModuleType, server: Server, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = manifest(tmp_path, server)
    assert (tool.main(arguments), tool.main(arguments)) == (0, 0)
    assert (tmp_path / "models" / "yolo.pt").read_bytes() == WEIGHTS
    told = capsys.readouterr().out
    assert "yolo.pt: 100 % of 5 MB" in told
    assert "SHA-256 is right" in told
    assert "already there" in told
    assert server.ranges == [None]


def test_a_download_that_breaks_off_goes_on_where_it_stopped(
    tool: ModuleType, server: Server, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    server.breaks = 2
    assert tool.main(manifest(tmp_path, server)) == 0
    assert (tmp_path / "models" / "yolo.pt").read_bytes() == WEIGHTS
    starts = [0 if one is None else int(one.removeprefix("bytes=").rstrip("-")) for one in server.ranges]
    assert starts == sorted(set(starts))
    assert len(starts) == 3
    assert "broke off" in capsys.readouterr().out


def test_what_was_complete_but_never_checked_is_only_checked(tool: ModuleType, server: Server, tmp_path: Path) -> None:
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "yolo.pt.part").write_bytes(WEIGHTS)
    assert tool.main(manifest(tmp_path, server)) == 0
    assert (tmp_path / "models" / "yolo.pt").read_bytes() == WEIGHTS


def test_a_file_with_another_hash_is_not_kept(
    tool: ModuleType, server: Server, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = manifest(tmp_path, server)
    server.files["yolo.pt"] = b"something else"
    assert tool.main(arguments) == 1
    assert list((tmp_path / "models").iterdir()) == []
    assert "not kept" in capsys.readouterr().out


def test_a_damaged_file_is_fetched_anew(tool: ModuleType, server: Server, tmp_path: Path) -> None:
    arguments = manifest(tmp_path, server)
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "yolo.pt").write_bytes(b"damaged")
    assert tool.main(arguments) == 0
    assert (tmp_path / "models" / "yolo.pt").read_bytes() == WEIGHTS


@pytest.mark.parametrize("reachable", [True, False])
def test_what_cannot_be_had_is_told_with_what_to_copy_where(
    tool: ModuleType, server: Server, tmp_path: Path, capsys: pytest.CaptureFixture[str], reachable: bool
) -> None:
    arguments = manifest(tmp_path, server)
    server.files.clear()
    if not reachable:
        server.server_close()
    assert tool.main(arguments) == 1
    told = capsys.readouterr().out
    assert ("the server said 404" in told) == reachable
    assert ("not reachable" in told) != reachable
    assert f"from  {server.url}/yolo.pt" in told
    assert f"to    {tmp_path / 'models' / 'yolo.pt'}" in told
    assert hashlib.sha256(WEIGHTS).hexdigest() in told


def test_a_mirror_changes_where_from_and_never_what(tool: ModuleType, server: Server, tmp_path: Path) -> None:
    arguments = manifest(tmp_path, server, url="http://127.0.0.1:9/yolo.pt")
    assert tool.main([*arguments, "--mirror", f"{server.url}/shared/"]) == 0
    server.files["yolo.pt"] = b"swapped"
    (tmp_path / "models" / "yolo.pt").unlink()
    assert tool.main([*arguments, "--mirror", f"{server.url}/shared/"]) == 1


@pytest.mark.filterwarnings("ignore:`torch.jit:DeprecationWarning")
def test_the_tensors_of_an_archive_are_taken_out_without_its_code(
    tool: ModuleType, server: Server, tmp_path: Path
) -> None:
    archive = tmp_path / "archive.pt"
    layer = torch.nn.Linear(3, 2)
    torch.jit.save(torch.jit.trace(layer, torch.zeros(1, 3)), str(archive))
    arguments = manifest(tmp_path, server, archive.read_bytes(), weights="models/yolo.safetensors")
    assert tool.main(arguments) == 0
    kept = load_file(str(tmp_path / "models" / "yolo.safetensors"))
    assert sorted(kept) == ["bias", "weight"]
    assert torch.equal(kept["weight"], layer.weight)


@pytest.mark.parametrize(
    ("steps", "code", "said"),
    [
        ([{"status": "pulling", "total": 10, "completed": 10}, {"status": "success"}], 0, "its layers checked"),
        ([{"status": "pulling"}, {"error": "pull model manifest: file does not exist"}], 1, "file does not exist"),
        ([{"status": "pulling"}], 1, "stopped at 'pulling'"),
    ],
)
def test_ollama_fetches_its_own(
    tool: ModuleType,
    server: Server,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    steps: list[dict[str, Any]],
    code: int,
    said: str,
) -> None:
    server.pull_steps = steps
    arguments = manifest(tmp_path, server)[:4]
    with (tmp_path / "table.toml").open("a", encoding="utf-8") as table:
        table.write('\n[[ollama]]\nmodel = "small:1b"\nwhat = "a reader"\n')
    assert tool.main([*arguments, "--only", "ollama", "--ollama-url", server.url]) == code
    assert said in capsys.readouterr().out
    assert server.pulled == ["small:1b"]


def test_the_table_of_the_repository_can_be_read() -> None:
    table = tomllib.loads((ROOT / "tools" / "models.toml").read_text(encoding="utf-8"))
    assert {entry["name"] for entry in table["file"]} == {"detector", "clip"}
    assert all(len(entry["sha256"]) == 64 for entry in table["file"])
    assert all(entry["url"].startswith("https://") for entry in table["file"])
