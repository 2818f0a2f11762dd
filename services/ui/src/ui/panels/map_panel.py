"""The map: a picture that changes rarely, two layers of marks above it, and the robot as an element that glides."""

from nicegui import ui as nicegui_ui

from ui import map_view
from ui.desk import Desk
from ui.panels.parts import box, section


class MapPanel:
    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._picture_version = ""
        self._marks: tuple[object, ...] = ()
        self._turn_deg: float = 0.0
        self._css: str = ""
        with section("Map", "map", title="Map"):
            with box("screen"):
                self._stage = box("stage")
                with self._stage:
                    self._image = nicegui_ui.element("img").props('alt="Map of the rooms"')
                    self._layers = nicegui_ui.html("", sanitize=False).classes("layers")
                    self._robot = box("robot").props('role=img aria-label="The robot"')
                    with self._robot:
                        box("nose")
                self._note = nicegui_ui.label("No map yet").classes("screen-note").props("role=status")
            with box("legend").props("aria-hidden=true"):
                for kind, text in (
                    ("trail", "driven"),
                    ("todo", "to look at"),
                    ("done", "looked at"),
                    ("target", "target"),
                ):
                    with box("key"):
                        box("swatch", kind)
                        nicegui_ui.label(text)
        self._stage.set_visibility(False)

    def show(self) -> None:
        """The picture and the marks; sends what changed."""
        picture, situation = self._desk.picture, self._desk.situation
        if picture is None:
            return
        if picture.version != self._picture_version:
            self._show_picture(picture)
        status = situation.mission
        target = status.mission.target_pose if status is not None and status.mission is not None else None
        todo = status.scan_points if status is not None else ()
        done = status.scan_points_done if status is not None else ()
        marks = (picture.version, situation.trail_version, todo, done, target)
        if marks != self._marks:
            self._marks = marks
            self._layers.set_content(
                map_view.layers_svg(
                    picture.frame, trail=situation.trail, points_todo=todo, points_done=done, target=target
                )
            )

    def _show_picture(self, picture: map_view.MapPicture) -> None:
        self._picture_version = picture.version
        frame = picture.frame
        self._image.props["src"] = f"/live/map.png?v={picture.version}"
        ratio = frame.width_px / frame.height_px
        self._stage.style(replace=f"aspect-ratio:{ratio:.4f};width:min(100cqw,{100 * ratio:.2f}cqh)")
        self._stage.set_visibility(True)
        self._note.set_visibility(False)

    def show_robot(self, *, fresh: bool) -> None:
        """The marker alone: some tens of bytes, and nothing while the robot stands."""
        picture, robot = self._desk.picture, self._desk.situation.robot
        pose = robot.pose if robot is not None else None
        if picture is None or pose is None:
            self._robot.set_visibility(False)
            return
        mark = map_view.marker(picture.frame, pose, self._turn_deg)
        self._robot.set_visibility(True)
        self._robot.classes(add="" if fresh else "old", remove="old" if fresh else "")
        if mark.css != self._css:
            self._css = mark.css
            self._turn_deg = mark.turn_deg
            size = 100.0 * picture.frame.px(2 * 0.17) / picture.frame.width_px
            self._robot.style(replace=f"{mark.css};width:max(20px,{size:.2f}%)")
