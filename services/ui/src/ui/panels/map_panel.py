"""The map: a picture that changes rarely, and a canvas above it that the browser draws (assets/map.js, belief.js)."""

from nicegui import ui as nicegui_ui

from contracts.rooms import ROOM_NAME_MAX
from ui import map_view
from ui.desk import Desk
from ui.i18n import N_, _
from ui.page_model import PageModel
from ui.panels.widgets import box, heading, section

LEGEND = (
    ("laser", N_("laser")),
    ("trail", N_("driven path")),
    ("planned", N_("planned path")),
    ("todo", N_("to search")),
    ("done", N_("searched")),
    ("thing", N_("remembered")),
    ("target", N_("target")),
)


class MapPanel:
    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._picture_version = ""
        with section(_("Map"), "map"):
            with box("row between card-head"):
                heading(_("Map"))
                nicegui_ui.element("button").classes("drive-switch push").props(
                    "type=button data-atom=belief-switch aria-pressed=false"
                ).add_slot("default", _("Where it may be"))
                self._halt = nicegui_ui.element("button").classes("drive-switch").props("type=button data-atom=halt")
                self._halt.add_slot("default", _("Stop driving there"))
            with box("screen"):
                self._stage = box("stage").props("data-atom=stage")
                with self._stage:
                    self._image = nicegui_ui.element("img").props(f'alt="{_("Map of the rooms")}"')
                    nicegui_ui.element("canvas").props("data-atom=map role=img").props(
                        f'aria-label="{_("Robot, laser, paths, search and remembered things")}"'
                    )
                    box("room-names").props("data-atom=room-names")
                    _room_dialog()
                    with box("here").props(f'data-atom=here hidden role=group aria-label="{_("This place")}"'):
                        for what, text in (
                            ("go", _("Go there")),
                            ("look", _("Turn to look there")),
                            ("close", _("Close")),
                        ):
                            nicegui_ui.element("button").props(f"type=button data-here={what}").add_slot(
                                "default", text
                            )
                self._note = nicegui_ui.label(_("No map yet")).classes("screen-note").props("role=status")
                box("place-note").props("data-atom=place-note role=status")
            _belief_words()
            with box("legend").props("aria-hidden=true"):
                for kind, text in LEGEND:
                    with box("key"):
                        box("swatch", kind)
                        nicegui_ui.label(_(text))
        self._stage.set_visibility(False)
        self._halt.set_visibility(False)

    def show(self, view: PageModel) -> None:
        """The picture, when it has changed."""
        self._halt.set_visibility(view.goal_open)
        picture = self._desk.picture
        if picture is not None and picture.version != self._picture_version:
            self._show_picture(picture)

    def _show_picture(self, picture: map_view.MapPicture) -> None:
        self._picture_version = picture.version
        frame = picture.frame
        self._image.props["src"] = f"live/map.png?v={picture.version}"
        ratio = frame.width_px / frame.height_px
        self._stage.style(replace=f"aspect-ratio:{ratio:.4f};width:min(100cqw,{100 * ratio:.2f}cqh)")
        self._stage.set_visibility(True)
        self._note.set_visibility(False)


def _room_dialog() -> None:
    """What a room is called (assets/rooms.js). Nothing behind it is shut off: STOP stays within reach."""
    with box("here room-ask").props(f'data-atom=room-ask hidden role=dialog aria-label="{_("Name this room")}"'):
        box("room-why").props("data-atom=room-why")
        nicegui_ui.element("input").props(
            f'type=text maxlength={ROOM_NAME_MAX} autocomplete=off aria-label="{_("Name of the room")}"'
        )
        for what, text in (("save", _("Name it")), ("unname", _("Take the name away")), ("close", _("Close"))):
            nicegui_ui.element("button").props(f"type=button data-naming={what}").add_slot("default", text)


def _belief_words() -> None:
    """Beside the layer of what the search holds probable (assets/belief.js); hidden with it."""
    with box("belief-words").props("data-atom=belief-words hidden"):
        with box("legend"):
            with box("key"):
                nicegui_ui.label(_("unlikely"))
                box("ramp")
                nicegui_ui.label(_("likely"))
                box().props("data-atom=belief-peak")
            with box("key"):
                box("swatch", "next")
                nicegui_ui.label(_("looks there next"))
            box("absent").props("data-atom=belief-absent")
        box().props("data-atom=belief-why role=status")
