"""Whatever answers where an Ollama server was set: a named error, and nothing of it goes anywhere else."""

import gzip
from collections.abc import AsyncIterator, Iterator

import pytest

from clients.ollama_server import ANSWER_BYTES_MAX, OllamaServer, RefusedError
from mesh.errors import MeshError, UnavailableError, UpstreamError
from support.language_servers import LanguageServer, OllamaHandler, Reply, running

ASKED = [{"role": "user", "content": "where to?"}]
NOT_OLLAMAS: dict[str, tuple[int, bytes]] = {
    "an error that is a list": (500, b"[]"),
    "an error that is a text": (500, b'"Bad Gateway"'),
    "an error that is null": (502, b"null"),
    "a proxy's page": (502, b"<html>Bad Gateway</html>"),
    "OpenAI's error": (401, b'{"error": {"message": "who are you?"}}'),
    "an error of null": (500, b'{"error": null}'),
    "an error of a number": (500, b'{"error": 5}'),
    "a list": (200, b"[]"),
    "null": (200, b"null"),
    "a text": (200, b'"x"'),
    "a number": (200, b"5"),
    "nested deeply": (200, b"[" * 100_000),
    "no text at all": (200, b"\xff\xfe\x00"),
}


@pytest.fixture
def server() -> Iterator[LanguageServer]:
    with running(OllamaHandler) as one:
        yield one


@pytest.fixture
async def ollama(server: LanguageServer) -> AsyncIterator[OllamaServer]:
    one = OllamaServer(server.url, "small", timeout_s=5.0)
    yield one
    await one.aclose()


async def ask(ollama: OllamaServer) -> str:
    return str((await ollama.chat(ASKED, options={})).message.content)


@pytest.mark.parametrize("what", NOT_OLLAMAS)
async def test_what_is_not_ollamas_is_an_error_of_the_mesh(
    server: LanguageServer, ollama: OllamaServer, what: str
) -> None:
    status, body = NOT_OLLAMAS[what]
    server.mood, server.raw = "as_it_is", (status, body, {})
    with pytest.raises(UpstreamError) as told:
        await ask(ollama)
    assert len(told.value.detail) < 400
    server.mood = "valid"
    server.says("on")
    assert await ask(ollama) == "on"


async def test_an_unknown_charset_in_an_error_is_one_too(server: LanguageServer, ollama: OllamaServer) -> None:
    server.mood, server.raw = "as_it_is", (500, b"00", {"Content-Type": "text/plain; charset=hex"})
    with pytest.raises(MeshError):
        await ask(ollama)


@pytest.mark.parametrize("status", [301, 302, 303, 307, 308])
async def test_no_redirect_is_followed(server: LanguageServer, ollama: OllamaServer, status: int) -> None:
    """To a stop's reset, say: the question would be its body."""
    with running(OllamaHandler) as other:
        other.says("reached")
        server.mood, server.raw = "as_it_is", (status, b"", {"Location": f"{other.url}/api/chat"})
        with pytest.raises(UpstreamError):
            await ask(ollama)
        assert other.asked == []


async def test_an_answer_that_would_grow_when_it_is_unpacked_is_not_read(
    server: LanguageServer, ollama: OllamaServer
) -> None:
    packed = gzip.compress(b" " * (50 * ANSWER_BYTES_MAX))
    assert len(packed) < ANSWER_BYTES_MAX
    server.mood, server.raw = "as_it_is", (200, packed, {"Content-Encoding": "gzip"})
    with pytest.raises(UnavailableError):
        await ask(ollama)
    assert server.headers_seen[0]["accept-encoding"] == "identity"


async def test_what_the_server_refuses_is_told_apart(server: LanguageServer, ollama: OllamaServer) -> None:
    server.mood, server.raw = "as_it_is", (400, b'{"error": "does not support tools"}', {})
    with pytest.raises(RefusedError, match="does not support tools"):
        await ask(ollama)


async def test_an_answer_is_read_to_its_bound(server: LanguageServer, ollama: OllamaServer) -> None:
    server.says(Reply({"content": "a" * (ANSWER_BYTES_MAX - 5_000)}))
    assert len(await ask(ollama)) == ANSWER_BYTES_MAX - 5_000
    server.says(Reply({"content": "a" * ANSWER_BYTES_MAX}))
    with pytest.raises(UnavailableError):
        await ask(ollama)
