"""Chromium as the tests of the page use it: no way out, complaints collected, pictures where wanted.

Requests are counted, not intercepted: an intercepted one would wait until the test next speaks to the browser.
"""

import logging
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

from playwright.sync_api import Browser, Error, Locator, Page, Request
from system_packages import chromium

CHROMIUM = chromium() or "chromium"
CHROMIUM_ARGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
    "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",  # the network cable is pulled
]
FAKE_MICROPHONE = ["--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream"]
"""A beep each second, given without a question; `--use-file-for-fake-audio-capture=FILE.wav%noloop` speaks the file."""
DESKTOP = {"width": 1280, "height": 800}
PHONE = {"width": 390, "height": 844}
SCREENS = Path(os.environ.get("ATOM_SCREENS", "out/screens"))
"""Where pictures of the page's states go; `make screens` writes those of the documentation."""

log = logging.getLogger(__name__)


@dataclass
class Seat:
    """Somebody before the page, with what the browser asked for elsewhere (in vain) and complained about."""

    page: Page
    outside: list[str] = field(default_factory=list)
    complaints: list[str] = field(default_factory=list)

    def picture(self, name: str, *, of: Locator | None = None) -> None:
        """Of the whole page, or of a part of it."""
        SCREENS.mkdir(parents=True, exist_ok=True)
        (of or self.page).screenshot(path=SCREENS / f"{name}.png", animations="disabled")


@contextmanager
def seated(browser: Browser, url: str, size: dict[str, int], *, dark: bool = False) -> Iterator[Seat]:
    """Opens the page, logs what it showed last; fails when it asked for anything from outside, or a script failed."""
    context = browser.new_context(
        viewport=size,  # pyright: ignore[reportArgumentType]
        color_scheme="dark" if dark else "light",
        has_touch=size is PHONE,
    )
    try:
        seat = Seat(context.new_page())

        def count(request: Request) -> None:
            if not request.url.startswith((url, "blob:", "data:")):
                seat.outside.append(request.url)

        seat.page.on("request", count)
        seat.page.on("pageerror", lambda error: seat.complaints.append(str(error)))
        seat.page.goto(url, timeout=60_000)
        try:
            yield seat
        finally:
            with suppress(Error):  # pytest shows it under a failed test
                log.warning("the page as the test left it:\n%s", seat.page.locator("body").aria_snapshot(timeout=5_000))
        assert seat.outside == []
        assert seat.complaints == []
    finally:
        context.close()
