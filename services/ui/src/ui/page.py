"""The page: one at `/`, put together from the panels, on NiceGUI with every asset from this process."""

import hashlib
import json
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Final, Literal

from fastapi import FastAPI, Request
from nicegui import app as nicegui_app
from nicegui import ui as nicegui_ui
from nicegui.language import Language
from starlette.staticfiles import StaticFiles

from mesh.access import Role, current_principal, requires_role
from ui import i18n, timeline_lines
from ui import page_model as words
from ui.desk import Desk
from ui.exploration_view import exploration_view
from ui.i18n import _
from ui.library_actions import LibraryActions
from ui.operator_actions import OperatorActions
from ui.panels.camera_panel import CameraPanel
from ui.panels.command_panel import CommandPanel
from ui.panels.header import Header
from ui.panels.history_panel import HistoryPanel
from ui.panels.map_panel import MapPanel
from ui.panels.memory_panel import MemoryPanel
from ui.panels.robot_panel import RobotPanel
from ui.panels.speech_panel import read_aloud
from ui.panels.stop import StoppedPanel, stop_html
from ui.panels.timeline import Timeline
from ui.panels.widgets import box
from ui.routes.deps import desk_of, operator, who_logged_in

ASSETS: Final = Path(__file__).parent / "assets"
SCRIPTS: Final = ("camera.js", "belief.js", "rooms.js", "map.js", "drive.js", "memory.js")
SPEECH_SCRIPT: Final = "speech.js"
RECONNECT_S: Final = 5.0
NOTES: Final[dict[words.Tone, Literal["positive", "warning", "negative"]]] = {
    words.Tone.GOOD: "positive",
    words.Tone.WARN: "warning",
    words.Tone.BAD: "negative",
}


def mount(app: FastAPI, *, language: Language) -> None:
    """Adds the page and its assets to the app. Routes already there come first."""
    app.mount("/assets", requires_role(Role.VIEWER)(StaticFiles(directory=ASSETS)), name="assets")
    requires_role(Role.VIEWER)(nicegui_app)  # the page itself, its scripts and its socket; what they do asks for more
    nicegui_ui.page("/", title="ATOM")(operator_page)
    nicegui_ui.run_with(  # pyright: ignore[reportUnknownMemberType]
        app,
        title="ATOM",
        favicon=(ASSETS / "icon.svg").read_text(),
        dark=None,
        language=language,
        tailwind=False,
        binding_refresh_interval=None,
        reconnect_timeout=RECONNECT_S,
        show_welcome_message=False,
    )


def operator_page(request: Request) -> None:
    OperatorPage(desk_of(request), request)


class OperatorPage:
    """One viewer's page; its timers run only while the browser is connected."""

    def __init__(self, desk: Desk, request: Request) -> None:
        self._desk = desk
        who, root_path = operator(request), request.scope.get("root_path", "")
        self._news_shown = desk.notifications.newest
        actions = OperatorActions(desk, lambda: current_principal(request))
        nicegui_ui.add_head_html(_head(root_path, (*SCRIPTS, SPEECH_SCRIPT) if desk.speech is not None else SCRIPTS))
        nicegui_ui.add_body_html(stop_html(desk.settings.robot_bridge_url))
        nicegui_ui.colors(primary="#1d56cf", negative="#c81e1e", positive="#15803d", warning="#a15c07")
        self._top = Header(who_logged_in(request))
        with box("board"):
            with box("say-or-stopped"):
                self._command = CommandPanel(
                    actions, with_speech=desk.speech is not None and actions.refused(Role.OPERATOR) is None
                )
                self._stopped = StoppedPanel(actions, who)
            self._live = CameraPanel()
            self._map = MapPanel(desk)
            self._build_side(desk, actions)
        self._show()
        settings = desk.settings
        nicegui_ui.timer(settings.state_period_s, self._show)
        nicegui_ui.timer(1.0, desk.refresh)
        nicegui_ui.timer(settings.memory_period_s, self._show_tab)

    def _build_side(self, desk: Desk, actions: OperatorActions) -> None:
        with nicegui_ui.element("section").classes("card side").props(f'aria-label="{_("Mission and robot")}"'):
            with nicegui_ui.tabs(on_change=self._show_tab).props(
                "dense no-caps align=justify inline-label"
            ) as self._tabs:
                for name, label in (
                    ("timeline", _("Timeline")),
                    ("memory", _("Memory")),
                    ("history", _("Missions")),
                    ("robot", _("Robot")),
                ):
                    nicegui_ui.tab(name, label=label)
            with nicegui_ui.tab_panels(self._tabs, value="timeline", animated=False, keep_alive=True).classes("panels"):
                with nicegui_ui.tab_panel("timeline"):
                    self._timeline = Timeline(desk)
                with nicegui_ui.tab_panel("memory"):
                    self._memory = MemoryPanel(desk, actions)
                with nicegui_ui.tab_panel("history"):
                    self._history = HistoryPanel(desk, self._timeline, self._open_timeline)
                with nicegui_ui.tab_panel("robot"):
                    self._machine = RobotPanel(actions, LibraryActions(desk, actions))

    def _open_timeline(self) -> None:
        self._tabs.set_value("timeline")

    def _view(self) -> words.PageModel:
        return words.page_model(
            self._desk.facts, now_s=self._desk.clock.now_s(), silence_s_max=self._desk.settings.silence_s_max
        )

    def _show(self) -> None:
        view, facts = self._view(), self._desk.facts
        mission = facts.mission.mission if facts.mission is not None else None
        self._top.show(view)
        self._command.show(view, facts.remembered)
        self._stopped.show(view)
        self._live.show(timeline_lines.vote_chips(mission.votes) if mission is not None else ())
        self._machine.show(view, exploration_view(facts.mission))
        self._map.show(view)
        self._timeline.show()
        for item in self._desk.notifications.after(self._news_shown):
            self._news_shown = item.number
            nicegui_ui.notify(
                item.text, type=NOTES.get(item.tone), position="bottom-left", timeout=12_000, close_button=_("Close")
            )
            if self._desk.speech is not None:
                read_aloud(item.text)

    async def _show_tab(self) -> None:
        match self._tabs.value:
            case "memory":
                self._memory.show()
            case "history":
                await self._history.show()
            case _:
                pass


def _head(root_path: str, scripts: Sequence[str]) -> str:
    """The base of every address of ours, none of which begins with a slash; style and scripts, named by their content
    so that a browser never keeps old ones; the scripts' words.

    Without a prefix there is no base, so that addresses also hold behind a proxy that does not say its own.
    """

    def named(name: str) -> str:
        return f"assets/{name}?v={hashlib.sha256((ASSETS / name).read_bytes()).hexdigest()[:10]}"

    base = f'<base href="{escape(root_path)}/">' if root_path else ""
    said = json.dumps(i18n.for_scripts()).replace("<", "\\u003c")
    return (
        f'{base}<script type="application/json" id="atom-texts">{said}</script>'
        f"<script>{(ASSETS / 'base.js').read_text(encoding='utf-8')}</script>"
        f'<link rel="stylesheet" href="{named("ui.css")}">'
        + "".join(f'<script defer src="{named(name)}"></script>' for name in scripts)
        + '<meta name="theme-color" content="#f4f6f9" media="(prefers-color-scheme: light)">'
        '<meta name="theme-color" content="#0e1318" media="(prefers-color-scheme: dark)">'
    )
