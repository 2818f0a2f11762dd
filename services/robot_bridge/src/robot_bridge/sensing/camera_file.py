"""The colour camera as it was last known whole: on the dock it may sleep, and then tells nothing."""

from pathlib import Path

import structlog
from pydantic import ValidationError

from contracts.description import CameraModel

log = structlog.get_logger()

FILE = "camera.json"


class CameraFile:
    def __init__(self, state_dir: Path) -> None:
        self._file = state_dir / FILE
        self.camera = self._load()
        """None before the first camera ever."""

    def keep(self, camera: CameraModel) -> None:
        if camera == self.camera:
            return
        self.camera = camera
        try:
            self._file.parent.mkdir(parents=True, exist_ok=True)
            self._file.write_text(camera.model_dump_json())
        except OSError as error:
            log.warning("the camera could not be stored", error=str(error))

    def _load(self) -> CameraModel | None:
        """None also where the file cannot be read: the camera tells itself again."""
        try:
            return CameraModel.model_validate_json(self._file.read_bytes())
        except (OSError, ValidationError):
            return None
