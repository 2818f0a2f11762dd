"""The page: one at `/`, put together from the panels, on NiceGUI with every asset from this process."""

import hashlib
from pathlib import Path
from typing import Final

from fastapi import FastAPI, Request
from nicegui import ui as nicegui_ui
from starlette.staticfiles import StaticFiles

from ui import view as words
from ui.desk import Desk
from ui.panels.command import Command
from ui.panels.live import Live
from ui.panels.machine import Machine
from ui.panels.map_panel import MapPanel
from ui.panels.parts import box
from ui.panels.stop import Stopped, stop_button
from ui.panels.timeline import Timeline
from ui.panels.top import Top
from ui.routes import get_desk, operator

ASSETS: Final = Path(__file__).parent / "assets"
RECONNECT_S: Final = 5.0


def mount(app: FastAPI) -> None:
    """Adds the page and its assets to the app. Routes already there come first."""
    app.mount("/assets", StaticFiles(directory=ASSETS), name="assets")
    nicegui_ui.page("/", title="ATOM")(operator_page)
    nicegui_ui.run_with(  # pyright: ignore[reportUnknownMemberType]
        app,
        title="ATOM",
        favicon=(ASSETS / "icon.svg").read_text(),
        dark=None,
        language="en-US",
        tailwind=False,
        binding_refresh_interval=None,
        reconnect_timeout=RECONNECT_S,
        show_welcome_message=False,
    )


def operator_page(request: Request) -> None:
    OperatorPage(get_desk(request), operator(request))


class OperatorPage:
    """One viewer's page; its timers run only while the browser is connected."""

    def __init__(self, desk: Desk, who: str) -> None:
        self._desk = desk
        nicegui_ui.add_head_html(_head())
        nicegui_ui.colors(primary="#2563eb", negative="#c81e1e")
        self._top = Top()
        with nicegui_ui.element("main").classes("board"):
            with box("say-or-stopped"):
                self._command = Command(desk)
                self._stopped = Stopped(desk, who)
            self._live = Live()
            self._map = MapPanel(desk)
            self._timeline = Timeline(desk)
            self._machine = Machine(desk)
        stop_button()
        self._show()
        settings = desk.settings
        nicegui_ui.timer(settings.marker_period_s, self._show_marker)
        nicegui_ui.timer(settings.state_period_s, self._show)
        nicegui_ui.timer(1.0, desk.refresh)

    def _view(self) -> words.View:
        return words.view(
            self._desk.situation, now_s=self._desk.clock.now_s(), silence_s_max=self._desk.settings.silence_s_max
        )

    def _show(self) -> None:
        view = self._view()
        self._top.show(view)
        self._command.show(view)
        self._stopped.show(view)
        self._live.show(view)
        self._machine.show(view)
        self._map.show()
        self._timeline.show()

    def _show_marker(self) -> None:
        age_s = self._desk.clock.now_s() - self._desk.situation.robot_at_s
        self._map.show_robot(fresh=age_s <= self._desk.settings.silence_s_max)


def _head() -> str:
    """Style and script, named by their content so that a browser never keeps old ones."""
    style, script = (hashlib.sha256((ASSETS / name).read_bytes()).hexdigest()[:10] for name in ("ui.css", "ui.js"))
    return (
        f'<link rel="stylesheet" href="/assets/ui.css?v={style}">'
        f'<script defer src="/assets/ui.js?v={script}"></script>'
        '<meta name="theme-color" content="#f4f6f9" media="(prefers-color-scheme: light)">'
        '<meta name="theme-color" content="#0e1318" media="(prefers-color-scheme: dark)">'
    )
