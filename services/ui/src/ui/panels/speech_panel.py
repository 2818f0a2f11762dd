"""Speaking to it: what the microphone hears, what that may mean, and whether answers are read aloud."""

import json

from nicegui import ui as nicegui_ui

from ui.i18n import _
from ui.panels.widgets import box


def microphone_button() -> None:
    button = nicegui_ui.element("button").classes("mic")
    button.props(f'type=button data-atom=mic aria-pressed=false aria-label="{_("Hold to speak")}"')
    button.props["title"] = _("Hold to speak; or hold the space bar")


class SpeechPanel:
    """What `assets/speech.js` shows itself in. Its settings are kept by the browser."""

    def __init__(self) -> None:
        with box("speech"):
            with box("row"):
                light = nicegui_ui.label(_("Microphone open")).classes("mic-light")
                light.props("hidden data-atom=mic-light role=status")
                box("meter").props("data-atom=meter aria-hidden=true")
                box("heard").props("data-atom=heard role=status")
            box("offers").props(f'data-atom=offers role=group aria-label="{_("What was meant")}"')
            with box("row settings"):
                _choice("at-once", _("Send at once what was heard"))
                _choice("aloud", _("Read answers aloud"))


def _choice(name: str, text: str) -> None:
    with nicegui_ui.element("label").classes("choice"):
        nicegui_ui.element("input").props(f"type=checkbox data-atom=speech-{name}")
        nicegui_ui.label(text)


def read_aloud(text: str) -> None:
    """On the page of this call, where its setting (`assets/speech.js`) says so."""
    nicegui_ui.run_javascript(f"window.atom.aloud && window.atom.aloud({json.dumps(text)})")
