"""The two CLIPs: the small one of our own for the simulated home, and open_clip's ViT-B/32 for a real one."""

import json
import re
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from contracts.colours import Colour
from inference.ports import Embeddings, RgbImage
from inference.settings import Precision

CLIP_MEAN_RGB = (122, 116, 104)
"""What open_clip's models subtract: a border of this colour is nothing to them."""
OPEN_CLIP_CROP_MARGIN = 0.15
"""Share of the longer box side shown all round."""
TIMED = 3


class ClipCard(BaseModel):
    """What belongs to the weights: read from the `.json` beside them, else what is right for ViT-B/32."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    architecture: str = Field(default="ViT-B-32-quickgelu", description="as open_clip names it")
    threshold: float = Field(
        default=0.24,
        ge=-1.0,
        le=1.0,
        description="cosine from which an image shows the phrase (requirement A11); it belongs to ViT-B/32 alone",
    )
    colour_margin: float = Field(default=0.015, ge=0.0, le=2.0)
    vote_margin: float = Field(default=0.0, ge=0.0, le=2.0)


def read_clip_card(weights: Path) -> ClipCard:
    """Raises ValueError where the `.json` beside the weights is not a card."""
    path = weights.with_suffix(".json")
    return ClipCard(**json.loads(path.read_text())["clip"]) if path.is_file() else ClipCard()


@dataclass(frozen=True, slots=True)
class Overrides:
    """Settings that take the place of a model's own numbers; none leaves them."""

    threshold: float | None = None
    colour_margin: float | None = None
    vote_margin: float | None = None


class SmallClipModel:
    """Raises FileNotFoundError when the weights or the .json beside them are missing."""

    backend = "open_clip (torch, fp32)"
    """bf16 gains nothing at this size: 2.6 ms and 3.6 ms for one crop."""
    colours = tuple(colour for colour in Colour if colour is not Colour.PINK)
    """Nothing in the simulated home is pink; an untaught word would pass for no colour at all, and win."""
    template = "{}"
    """Its threshold was measured on bare phrases such as 'red bottle'."""

    def __init__(self, path: Path, *, overrides: Overrides | None = None) -> None:
        if not path.exists():
            raise FileNotFoundError(f"no image-text weights at {path}")
        from inference.perception import small_clip

        self._crop = small_clip.crop
        self._model = small_clip.load(path)
        self._words = frozenset(self._model.config.words)
        self.name = self._model.name
        self.backends_ms: dict[str, float] = {}
        own, said = self._model.config, overrides or Overrides()
        self.threshold = own.threshold if said.threshold is None else said.threshold
        self.colour_margin = own.colour_margin if said.colour_margin is None else said.colour_margin
        self.vote_margin = own.vote_margin if said.vote_margin is None else said.vote_margin

    def known(self, text: str) -> tuple[str, tuple[str, ...]]:
        words = re.findall(r"[a-z0-9]+", text.lower())
        readable = [word for word in words if word in self._words]
        return " ".join(readable), tuple(word for word in words if word not in self._words)

    def crop(self, image: RgbImage, bbox_xyxy: Sequence[float]) -> RgbImage:
        return self._crop(image, bbox_xyxy)

    def embed_image(self, crops: Sequence[RgbImage]) -> Embeddings:
        return self._model.embed_image(crops)

    def embed_text(self, texts: Sequence[str]) -> Embeddings:
        return self._model.embed_text(texts)


class OpenClipModel:
    """A model of open_clip from a file on this machine: nothing is fetched.

    Raises FileNotFoundError without it. Precision `auto` keeps the faster of fp32 and bf16, timed at load.
    """

    colours = tuple(Colour)
    template = "a photo of {}"

    def __init__(
        self, path: Path, *, precision: Precision = Precision.AUTO, overrides: Overrides | None = None
    ) -> None:
        if not path.exists():
            raise FileNotFoundError(f"no image-text weights at {path}")
        card, said = read_clip_card(path), overrides or Overrides()
        from inference.perception import torchvision_cpu

        torchvision_cpu.install()
        import open_clip as library
        import torch

        open_clip: Any = library
        self._torch: Any = torch
        model, _, preprocess = open_clip.create_model_and_transforms(card.architecture, pretrained=str(path))
        self._model: Any = model.eval()
        self._preprocess: Any = preprocess
        self._tokenizer: Any = open_clip.get_tokenizer(card.architecture)
        self.name = card.architecture.removesuffix("-quickgelu")
        self.threshold = card.threshold if said.threshold is None else said.threshold
        self.colour_margin = card.colour_margin if said.colour_margin is None else said.colour_margin
        self.vote_margin = card.vote_margin if said.vote_margin is None else said.vote_margin
        self._bf16 = precision is Precision.BF16
        self.backends_ms: dict[str, float] = {}
        if precision is Precision.AUTO:
            self.backends_ms = {str(one): self._image_ms(one) for one in (Precision.FP32, Precision.BF16)}
            self._bf16 = self.backends_ms[Precision.BF16] < self.backends_ms[Precision.FP32]

    @property
    def backend(self) -> str:
        return f"open_clip (torch, {Precision.BF16 if self._bf16 else Precision.FP32})"

    def known(self, text: str) -> tuple[str, tuple[str, ...]]:
        return text, ()

    def crop(self, image: RgbImage, bbox_xyxy: Sequence[float]) -> RgbImage:
        """The box with 15 % of its longer side all round."""
        height_px, width_px = image.shape[:2]
        margin = OPEN_CLIP_CROP_MARGIN * max(bbox_xyxy[2] - bbox_xyxy[0], bbox_xyxy[3] - bbox_xyxy[1])
        left = int(np.clip(bbox_xyxy[0] - margin, 0, width_px - 1))
        top = int(np.clip(bbox_xyxy[1] - margin, 0, height_px - 1))
        right = int(np.clip(np.ceil(bbox_xyxy[2] + margin), left + 1, width_px))
        bottom = int(np.clip(np.ceil(bbox_xyxy[3] + margin), top + 1, height_px))
        return image[top:bottom, left:right]

    def embed_image(self, crops: Sequence[RgbImage]) -> Embeddings:
        from PIL import Image

        batch = [self._preprocess(Image.fromarray(squared(one))) for one in crops]
        return self._run(lambda: self._model.encode_image(self._torch.stack(batch), normalize=True))

    def embed_text(self, texts: Sequence[str]) -> Embeddings:
        return self._run(lambda: self._model.encode_text(self._tokenizer(list(texts)), normalize=True))

    def _run(self, encode: Callable[[], Any]) -> Embeddings:
        with self._torch.inference_mode(), self._torch.autocast("cpu", self._torch.bfloat16, enabled=self._bf16):
            found = encode().float()
        return (found / found.norm(dim=-1, keepdim=True)).numpy()

    def _image_ms(self, precision: Precision) -> float:
        self._bf16 = precision is Precision.BF16
        took_s: list[float] = []
        for _ in range(1 + TIMED):
            began_s = time.perf_counter()
            self.embed_image([np.zeros((224, 224, 3), np.uint8)])
            took_s.append(time.perf_counter() - began_s)
        return round(min(took_s[1:]) * 1000, 1)


def squared(image: RgbImage) -> RgbImage:
    """Padded to a square: open_clip cuts the middle out of anything else, and a bottle would lose both ends."""
    height_px, width_px = image.shape[:2]
    side_px = max(height_px, width_px)
    canvas = np.full((side_px, side_px, 3), CLIP_MEAN_RGB, np.uint8)
    top, left = (side_px - height_px) // 2, (side_px - width_px) // 2
    canvas[top : top + height_px, left : left + width_px] = image
    return canvas
