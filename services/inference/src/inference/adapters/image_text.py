"""The two CLIPs: the small one of our own for the simulated home, and open_clip's ViT-B/32 for a real one."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from contracts.coco import COLOURS
from inference.ports import Embeddings, RgbImage

VIT_B_32_THRESHOLD = 0.24
"""Cosine from which an image shows the phrase (requirement A11); it belongs to ViT-B/32 alone."""
VIT_B_32_CROP_MARGIN = 0.15


class SmallClipModel:
    """Raises FileNotFoundError when the weights or the .json beside them are missing."""

    backend = "open_clip (torch)"
    colours = tuple(colour for colour in COLOURS if colour != "pink")
    """Nothing in the simulated home is pink; an untaught word would pass for no colour at all, and win."""
    template = "{}"
    """Its threshold was measured on bare phrases such as 'red bottle'."""

    def __init__(self, path: Path, *, threshold: float | None = None, colour_margin: float | None = None) -> None:
        if not path.exists():
            raise FileNotFoundError(f"no image-text weights at {path}")
        from inference import small_clip

        self._crop = small_clip.crop
        self._model = small_clip.load(path)
        self._words = frozenset(self._model.config.words)
        self.name = self._model.name
        self.threshold = threshold if threshold is not None else self._model.threshold
        self.colour_margin = colour_margin if colour_margin is not None else 0.08

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
    """open_clip's ViT-B/32 from a file on this machine: nothing is fetched. Raises FileNotFoundError without it."""

    backend = "open_clip (torch)"
    colours = COLOURS
    template = "a photo of {}"

    def __init__(self, path: Path, *, threshold: float | None = None, colour_margin: float | None = None) -> None:
        if not path.exists():
            raise FileNotFoundError(f"no image-text weights at {path}")
        from inference import torchvision_cpu

        torchvision_cpu.install()
        import open_clip as library
        import torch

        open_clip: Any = library
        self._torch = torch
        model, _, preprocess = open_clip.create_model_and_transforms("ViT-B-32-quickgelu", pretrained=str(path))
        self._model: Any = model.eval()
        self._preprocess: Any = preprocess
        self._tokenizer: Any = open_clip.get_tokenizer("ViT-B-32-quickgelu")
        self.name = "ViT-B-32"
        self.threshold = threshold if threshold is not None else VIT_B_32_THRESHOLD
        self.colour_margin = colour_margin if colour_margin is not None else 0.015

    def known(self, text: str) -> tuple[str, tuple[str, ...]]:
        return text, ()

    def crop(self, image: RgbImage, bbox_xyxy: Sequence[float]) -> RgbImage:
        """The box with 15 % of its longer side all round."""
        height_px, width_px = image.shape[:2]
        margin = VIT_B_32_CROP_MARGIN * max(bbox_xyxy[2] - bbox_xyxy[0], bbox_xyxy[3] - bbox_xyxy[1])
        left = int(np.clip(bbox_xyxy[0] - margin, 0, width_px - 1))
        top = int(np.clip(bbox_xyxy[1] - margin, 0, height_px - 1))
        right = int(np.clip(np.ceil(bbox_xyxy[2] + margin), left + 1, width_px))
        bottom = int(np.clip(np.ceil(bbox_xyxy[3] + margin), top + 1, height_px))
        return image[top:bottom, left:right]

    def embed_image(self, crops: Sequence[RgbImage]) -> Embeddings:
        from PIL import Image

        with self._torch.inference_mode():
            batch = self._torch.stack([self._preprocess(Image.fromarray(one)) for one in crops])
            return self._model.encode_image(batch, normalize=True).float().numpy()

    def embed_text(self, texts: Sequence[str]) -> Embeddings:
        with self._torch.inference_mode():
            return self._model.encode_text(self._tokenizer(list(texts)), normalize=True).float().numpy()
