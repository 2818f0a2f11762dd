"""Chromium as the tests of the page use it: nothing from outside, complaints collected, pictures where wanted."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from playwright.sync_api import Browser, Page, Route

CHROMIUM = "/usr/bin/chromium"
CHROMIUM_ARGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
]
DESKTOP = {"width": 1280, "height": 800}
PHONE = {"width": 390, "height": 844}
SCREENS = Path(os.environ.get("ATOM_SCREENS", "out/screens"))
"""Where pictures of the page's states go; `make screens` writes those of the documentation."""


@dataclass
class Seat:
    """Somebody before the page, with what the browser asked for elsewhere (blocked) and complained about."""

    page: Page
    outside: list[str] = field(default_factory=list)
    complaints: list[str] = field(default_factory=list)

    def picture(self, name: str) -> None:
        SCREENS.mkdir(parents=True, exist_ok=True)
        self.page.screenshot(path=SCREENS / f"{name}.png")


@contextmanager
def seated(browser: Browser, url: str, size: dict[str, int], *, dark: bool = False) -> Iterator[Seat]:
    """Opens the page; fails when it asked for anything from outside, or a script of it failed."""
    context = browser.new_context(
        viewport=size,  # pyright: ignore[reportArgumentType]
        color_scheme="dark" if dark else "light",
        has_touch=size is PHONE,
    )
    try:
        seat = Seat(context.new_page())

        def only_from_here(route: Route) -> None:
            if route.request.url.startswith((url, "blob:", "data:")):
                route.continue_()
            else:
                seat.outside.append(route.request.url)
                route.abort()

        context.route("**/*", only_from_here)
        seat.page.on("pageerror", lambda error: seat.complaints.append(str(error)))
        seat.page.goto(url, timeout=60_000)
        yield seat
        assert seat.outside == []
        assert seat.complaints == []
    finally:
        context.close()
