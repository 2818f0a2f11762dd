"""Stand-ins for the inference service's ports; one suite runs over them and the real things (integration/inference)."""

import asyncio
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np

from contracts.colours import Colour
from contracts.geometry import Point3D, Pose2D
from contracts.measuring import LocalizeRequest, Measurement
from contracts.vision import Detection, ModelInfo
from inference.perception.models import Loaded
from inference.ports import Completion, Embeddings, Frame, Prompt, RgbImage
from mesh.errors import UnavailableError

RGB = {
    "red": (200, 20, 20), "green": (20, 170, 40), "blue": (30, 40, 210), "yellow": (230, 220, 30),
    "white": (240, 240, 240), "black": (15, 15, 15), "purple": (140, 30, 160), "orange": (240, 130, 20),
    "brown": (110, 70, 30), "pink": (250, 150, 180), "grey": (120, 120, 120),
}  # fmt: skip
POSE = Pose2D(x=1.0, y=2.0, yaw=0.5)


def picture(*things: tuple[str, tuple[int, int, int, int]], width_px: int = 250, height_px: int = 250) -> RgbImage:
    """A pale room with coloured boxes in it."""
    image = np.full((height_px, width_px, 3), (205, 200, 190), np.uint8)
    for colour, (left, top, right, bottom) in things:
        image[top:bottom, left:right] = RGB[colour]
    return image


def jpeg_of(image: RgbImage) -> bytes:
    return cv2.imencode(".jpg", cv2.cvtColor(image, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, 95])[1].tobytes()


def bottle(bbox: tuple[float, float, float, float] = (80, 60, 130, 200), confidence: float = 0.9) -> Detection:
    return Detection(label="bottle", confidence=confidence, bbox_xyxy=bbox)


class FakeCamera:
    """Shows what `show` was given; `away` makes it unreachable."""

    def __init__(self) -> None:
        self.away = False
        self.asked = 0
        self.localized: list[LocalizeRequest] = []
        self.localize_fails = False
        self.detail = "no depth camera"
        self.localize_hangs = False
        self._frame: Frame | None = None
        self._changed = asyncio.Event()

    def show(self, stamp_s: float, image: RgbImage | bytes, pose: Pose2D | None = POSE) -> None:
        self._frame = Frame(stamp_s, image if isinstance(image, bytes) else jpeg_of(image), pose)
        self._changed.set()

    async def newest(self, *, after_s: float | None, wait_s: float) -> Frame | None:
        self.asked += 1
        if self.away:
            raise UnavailableError("robot_bridge", "not reachable")
        try:
            async with asyncio.timeout(wait_s):
                while self._frame is None or (after_s is not None and self._frame.stamp_s <= after_s):
                    self._changed.clear()
                    await self._changed.wait()
        except TimeoutError:
            return None
        return self._frame

    async def localize(self, request: LocalizeRequest) -> tuple[Measurement, ...]:
        """Each box at a place of its own: 1 m, 2 m ... ahead of the map's origin."""
        self.localized.append(request)
        if self.localize_fails:
            raise UnavailableError("robot_bridge", self.detail)
        if self.localize_hangs:
            await asyncio.Event().wait()
        return tuple(
            Measurement(distance_m=x, depth_m=x, sigma_m=0.01, map_point=Point3D(x=x, y=0.0, z=0.2))
            for x in map(float, range(1, len(request.boxes_xyxy) + 1))
        )

    async def aclose(self) -> None:
        return


@dataclass
class FakeDetector:
    """Sees what it is told to see."""

    found: tuple[Detection, ...] = ()
    name: str = "fake-detector"
    backend: str = "fake"
    threshold: float = 0.30
    trouble: str = ""
    backends_ms: dict[str, float] = field(default_factory=dict[str, float])
    sizes: list[tuple[int, int]] = field(default_factory=list)

    def detect(self, image: RgbImage) -> tuple[Detection, ...]:
        self.sizes.append((image.shape[1], image.shape[0]))
        return self.found


class FakeClip:
    """Knows colours alone: an image is its middle pixel's colour, a phrase the first colour word in it."""

    name = "fake-clip"
    backend = "fake"
    template = "{}"

    def __init__(self, *, threshold: float = 0.90, colour_margin: float = 0.01, words: Sequence[str] = ()) -> None:
        self.backends_ms: dict[str, float] = {}
        self.threshold = threshold
        self.colour_margin = colour_margin
        self.vote_margin = 0.0
        self.colours = tuple(Colour)
        self._words = {*RGB, "bottle", "cup", "mug", "wooden", *words}

    def known(self, text: str) -> tuple[str, tuple[str, ...]]:
        words = text.lower().split()
        return " ".join(w for w in words if w in self._words), tuple(w for w in words if w not in self._words)

    def crop(self, image: RgbImage, bbox_xyxy: Sequence[float]) -> RgbImage:
        left, top, right, bottom = (max(0, int(value)) for value in bbox_xyxy)
        left, top = min(left, image.shape[1] - 1), min(top, image.shape[0] - 1)
        return image[top : max(top + 1, bottom), left : max(left + 1, right)]

    def embed_image(self, crops: Sequence[RgbImage]) -> Embeddings:
        return np.stack([_unit(one[one.shape[0] // 2, one.shape[1] // 2]) for one in crops])

    def embed_text(self, texts: Sequence[str]) -> Embeddings:
        said = [next((word for word in text.split() if word in RGB), None) for text in texts]
        return np.stack([_unit(np.array(RGB[word] if word else (205, 200, 190))) for word in said])


def _unit(rgb: np.ndarray) -> np.ndarray:
    vector = np.append(rgb.astype(np.float32) - 128.0, 40.0)
    return (vector / np.linalg.norm(vector)).astype(np.float32)


@dataclass
class FakeLanguageModel:
    """A language model and a third voter in one: answers, refuses, or never answers."""

    says: object = None
    presence: bool = True
    hangs: bool = False
    away: bool = False
    asked: int = 0
    name: str = "fake:llm"
    backend: str = "fake"

    async def complete(self, prompt: Prompt) -> Completion:
        await self._mood()
        return Completion(self.says if isinstance(self.says, str) else json.dumps(self.says))

    def info(self) -> ModelInfo:
        return ModelInfo(role="vlm", name=self.name, backend=self.backend)

    async def present(self, jpeg: bytes, description: str) -> bool:
        await self._mood()
        return self.presence

    async def aclose(self) -> None:
        return

    async def _mood(self) -> None:
        self.asked += 1
        if self.hangs:
            await asyncio.Event().wait()
        if self.away:
            raise UnavailableError(self.name, "not reachable")


def loads(
    *, detector: FakeDetector | None = None, clip: FakeClip | None = None, problems: tuple[str, ...] = ()
) -> Callable[[], Loaded]:
    """A loader for `create_app`."""
    return lambda: Loaded(detector=detector, clip=clip, problems=problems)
