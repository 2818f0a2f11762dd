"""What the service needs of the world: eyes, a reader, a camera. Models block; the worker thread calls them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from contracts.colours import Colour
from contracts.geometry import Pose2D
from contracts.measuring import LocalizeRequest, Measurement
from contracts.vision import Detection, ModelInfo

RgbImage = npt.NDArray[np.uint8]
"""(height, width, 3), red first."""
Embeddings = npt.NDArray[np.float32]
"""(n, d), unit vectors: a dot product is a cosine."""
MODEL_ERRORS = (RuntimeError, ValueError, TypeError, LookupError, AttributeError)
"""What torch, OpenVINO, ONNX Runtime and the libraries on them raise where a model fails on a picture or a text."""
CONNECT_TIMEOUT_S = 3.0
"""A server of language models that has not picked up by then is down."""

THINKING_TOKENS_MAX = 1000
"""Given on top of an answer's to a model that thinks aloud although it was told not to; deadlines hold all the same."""


@dataclass(frozen=True, slots=True)
class Frame:
    """One camera frame as it came: JPEG bytes, when it was taken, and where the robot stood."""

    stamp_s: float
    jpeg: bytes
    pose: Pose2D | None = None


class Model(Protocol):
    @property
    def name(self) -> str: ...

    @property
    def backend(self) -> str: ...

    @property
    def backends_ms(self) -> Mapping[str, float]:
        """Milliseconds of one image by each backend, or in each precision, that was tried; empty without a choice."""
        ...

    @property
    def threshold(self) -> float:
        """Confidence or cosine from which it says yes: boxes below are not returned, phrases below do not fit."""
        ...


class Detector(Model, Protocol):
    @property
    def trouble(self) -> str:
        """What was wrong with its answer to the last image; empty when nothing was."""
        ...

    def detect(self, image: RgbImage) -> tuple[Detection, ...]:
        """Boxes in pixels of `image`, best first, each inside it. Raises `UnavailableError` where it cannot look."""
        ...


class FasterDetector(Protocol):
    """A detector on a backend that needs preparing."""

    async def prepare(self) -> str:
        """Takes seconds to minutes; returns what went wrong, or nothing."""
        ...

    def load(self) -> Detector:
        """Blocks; to be called once it is prepared."""
        ...


class ImageText(Model, Protocol):
    """A CLIP: tells how well an image and a phrase go together."""

    @property
    def colour_margin(self) -> float:
        """Cosine by which the best colour must lead the next to be believed."""
        ...

    @property
    def vote_margin(self) -> float:
        """Cosine by which a description must lead itself in every other colour to get this model's vote."""
        ...

    @property
    def colours(self) -> tuple[Colour, ...]:
        """The colour words it was taught: only these are asked for, and only these are rivals."""
        ...

    @property
    def template(self) -> str:
        """How a phrase is put to this model, e.g. 'a photo of {}'."""
        ...

    def known(self, text: str) -> tuple[str, tuple[str, ...]]:
        """The text as far as the model can read it, and the words it cannot."""
        ...

    def crop(self, image: RgbImage, bbox_xyxy: Sequence[float]) -> RgbImage:
        """The box with the margin the model expects; never empty."""
        ...

    def embed_image(self, crops: Sequence[RgbImage]) -> Embeddings:
        """One row a crop; the caller looks whether they are numbers (`embeddings.unit`)."""
        ...

    def embed_text(self, texts: Sequence[str]) -> Embeddings: ...


@dataclass(frozen=True, slots=True)
class Prompt:
    """One question to a language model: fixed instructions, data, and the JSON schema of the answer."""

    system: str
    question: str
    schema: Mapping[str, Any]
    images: tuple[bytes, ...] = ()
    """JPEG."""
    answer_tokens_max: int = 200
    temperature: float = 0.0


class Ending(StrEnum):
    """How a model's answer ended."""

    WHOLE = "whole"
    CUT_OFF = "cut_off"
    """Its tokens were used up."""
    REFUSED = "refused"
    """It would not answer; `Completion.text` is what it said instead."""


@dataclass(frozen=True, slots=True)
class Completion:
    """An answer as it came, not yet checked against the schema."""

    text: str
    thoughts: str = ""
    """What it thought aloud, where its server keeps that apart."""
    ending: Ending = Ending.WHOLE


class LanguageModel(Protocol):
    """One model of one server, whatever wire format that speaks; with images, a vision-language model."""

    @property
    def name(self) -> str:
        """'<backend>:<model>'."""
        ...

    @property
    def backend(self) -> str: ...

    async def complete(self, prompt: Prompt) -> Completion:
        """One answer, in whatever form the model gives it.

        Raises `UnavailableError` (away, slow) or `UpstreamError` (it refused, or spoke another wire format).
        """
        ...

    async def aclose(self) -> None: ...


class VisionLanguageModel(Protocol):
    @property
    def name(self) -> str: ...

    def info(self) -> ModelInfo:
        """What it is, and how it does."""
        ...

    async def present(self, jpeg: bytes, description: str) -> bool:
        """Is there a `description` visible? Raises `UnavailableError` (away, slow, no sense in its answers)."""
        ...


class Camera(Protocol):
    async def newest(self, *, after_s: float | None, wait_s: float) -> Frame | None:
        """The newest frame later than `after_s`, waited for up to `wait_s`; none when there was none.

        Raises `UnavailableError` when the camera's owner cannot be reached.
        """
        ...

    async def localize(self, request: LocalizeRequest) -> tuple[Measurement, ...]:
        """How far away and where the things in the boxes are, in their order.

        Raises `UnavailableError` or `UpstreamError` where nobody says.
        """
        ...

    async def aclose(self) -> None: ...
