"""No service tells its own key: not by a route that is open, nor by its settings, nor in what it logs as it is made."""

from pathlib import Path

import access_page
import httpx
import pytest

from contracts.access import CALLERS, CredentialFile

PLANTED = "planted-5d41402abc4b2a76"
OPEN = ("/openapi.json", "/docs", "/health", "/login", "/nowhere", f"/state?key={PLANTED[::-1]}")


@pytest.mark.parametrize("service", CALLERS)
async def test_a_planted_key_is_found_nowhere(
    service: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture,
    capfd: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    (tmp_path / "keys.json").write_text(CredentialFile().model_dump_json())
    monkeypatch.setenv(f"{service.upper()}_KEYS_FILE", str(tmp_path / "keys.json"))
    monkeypatch.setenv(f"{service.upper()}_KEY", PLANTED)
    app = access_page.app_of(service)
    wrong = {"Authorization": f"Bearer {PLANTED[::-1]}"}
    async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://sample") as client:
        answers = [await client.get(path, headers=wrong) for path in OPEN]
    said = capfd.readouterr()
    told = "".join([caplog.text, said.out, said.err, *(f"{one.headers}{one.text}" for one in answers)])
    assert "a wrong key" in told
    assert PLANTED not in told
    assert PLANTED[::-1] not in told
