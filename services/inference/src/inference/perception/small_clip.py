"""A small CLIP for the simulated home: loads an open_clip model of ours and embeds crops and phrases.

Two files make a model: `NAME.safetensors` (fp16 weights) and `NAME.json` beside it (shape, vocabulary, threshold).
Neither can carry code. The text tower reads whole words from its own short vocabulary; a word it does not know becomes
one shared "unknown" token. Scores are cosines; `threshold` was measured for this model on homes it never saw and means
nothing for another (0.24, for one, belongs to ViT-B/32).
"""

import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import torch
from safetensors.torch import load_file, save_file

from inference.perception import torchvision_cpu

PAD, START, UNKNOWN, FIRST_WORD = 0, 1, 2, 3
GREY = 127
CROP_MARGIN = 0.08
"""Share of the longer box side added all round before a box is cut out; the model was trained on such crops."""


@dataclass(frozen=True)
class ClipConfig:
    """What is needed to build the model again, and to read its scores."""

    name: str
    words: tuple[str, ...]
    threshold: float
    colour_margin: float = 0.08
    """Cosine by which the best colour must lead the next before a thing is called by it."""
    vote_margin: float = 0.0
    """Cosine by which a phrase must lead itself in every other colour before a crop counts as showing it."""
    image_size_px: int = 64
    context_length: int = 16
    embed_dim: int = 128
    vision_layers: tuple[int, int, int, int] = (1, 1, 1, 1)
    vision_width: int = 16
    text_width: int = 96
    text_layers: int = 1

    @property
    def end_token(self) -> int:
        """The highest id: open_clip pools the text where the id is largest."""
        return FIRST_WORD + len(self.words)


def crop(image_rgb: npt.NDArray[np.uint8], bbox_xyxy: Sequence[float]) -> npt.NDArray[np.uint8]:
    """The part of `image_rgb` (h, w, 3) inside the box, with the margin the model expects, never empty."""
    height_px, width_px = image_rgb.shape[:2]
    x_min, y_min, x_max, y_max = bbox_xyxy
    margin_px = CROP_MARGIN * max(x_max - x_min, y_max - y_min)
    left = int(np.clip(np.floor(x_min - margin_px), 0, width_px - 1))
    top = int(np.clip(np.floor(y_min - margin_px), 0, height_px - 1))
    right = int(np.clip(np.ceil(x_max + margin_px), left + 1, width_px))
    bottom = int(np.clip(np.ceil(y_max + margin_px), top + 1, height_px))
    return image_rgb[top:bottom, left:right]


def letterbox(image_rgb: npt.NDArray[np.uint8], size_px: int) -> npt.NDArray[np.uint8]:
    """The crop scaled into a (size_px, size_px, 3) grey square: its proportions say much about its kind."""
    height_px, width_px = image_rgb.shape[:2]
    scale = size_px / max(height_px, width_px)
    width, height = max(1, round(width_px * scale)), max(1, round(height_px * scale))
    method = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    canvas = np.full((size_px, size_px, 3), GREY, np.uint8)
    left, top = (size_px - width) // 2, (size_px - height) // 2
    canvas[top : top + height, left : left + width] = cv2.resize(image_rgb, (width, height), interpolation=method)
    return canvas


def tokenize(texts: Sequence[str], config: ClipConfig) -> torch.Tensor:
    """Token ids (n, context_length): start, the words, end, padding; words beyond the context are dropped."""
    ids = {word: FIRST_WORD + i for i, word in enumerate(config.words)}
    tokens = torch.full((len(texts), config.context_length), PAD, dtype=torch.long)
    for row, text in enumerate(texts):
        words = re.findall(r"[a-z0-9]+", text.lower())[: config.context_length - 2]
        line = [START, *(ids.get(word, UNKNOWN) for word in words), config.end_token]
        tokens[row, : len(line)] = torch.tensor(line)
    return tokens


def to_tensor(squares: npt.NDArray[np.uint8]) -> torch.Tensor:
    """(n, s, s, 3) bytes to the (n, 3, s, s) floats in -1..1 that the image tower reads."""
    return torch.from_numpy(squares).permute(0, 3, 1, 2).float() / 127.5 - 1.0


def build(config: ClipConfig) -> Any:
    """A fresh open_clip `CLIP` of the configured shape, untrained."""
    torchvision_cpu.install()
    from open_clip.model import CLIP

    return CLIP(
        embed_dim=config.embed_dim,
        vision_cfg={
            "image_size": config.image_size_px,
            "layers": list(config.vision_layers),
            "width": config.vision_width,
            "head_width": 64,
        },
        text_cfg={
            "context_length": config.context_length,
            "vocab_size": config.end_token + 1,
            "width": config.text_width,
            "heads": 4,
            "layers": config.text_layers,
        },
    )


def save(path: Path, model: torch.nn.Module, config: ClipConfig, notes: Mapping[str, Any]) -> None:
    """Write `path` (.safetensors, fp16) and its .json; `notes` says how it was made and how well it does."""
    weights = {
        name: (value.half() if value.is_floating_point() else value).contiguous()
        for name, value in model.state_dict().items()
    }
    save_file(weights, path)
    fields = {**config.__dict__, "words": list(config.words), "vision_layers": list(config.vision_layers)}
    path.with_suffix(".json").write_text(json.dumps({"model": fields, "notes": dict(notes)}, indent=1) + "\n")


def read_config(path: Path) -> ClipConfig:
    """The configuration beside the weights at `path`; raises FileNotFoundError, KeyError, TypeError or ValueError."""
    fields = json.loads(path.with_suffix(".json").read_text())["model"]
    fields["words"], fields["vision_layers"] = tuple(fields["words"]), tuple(fields["vision_layers"])
    config = ClipConfig(**fields)
    if not all(map(math.isfinite, (config.threshold, config.colour_margin, config.vote_margin))):
        raise ValueError(f"{path}: a threshold or a margin is no number")
    return config


class SmallClip:
    """The loaded model; both embeddings are unit vectors, so that their dot product is the cosine."""

    def __init__(self, model: Any, config: ClipConfig) -> None:
        self._model = model.float().eval()
        self.config = config

    @property
    def name(self) -> str:
        """The model's name, as shown in `/models` and in a vote."""
        return self.config.name

    @property
    def threshold(self) -> float:
        """The cosine from which a crop counts as showing the phrase."""
        return self.config.threshold

    @torch.inference_mode()
    def embed_image(self, crops: Sequence[npt.NDArray[np.uint8]]) -> npt.NDArray[np.float32]:
        """Embeddings (n, 128) of RGB crops of any size (h, w, 3), cut with `crop`."""
        if not crops:
            return np.zeros((0, self.config.embed_dim), np.float32)
        return self.embed_squares(np.stack([letterbox(one, self.config.image_size_px) for one in crops]))

    @torch.inference_mode()
    def embed_squares(self, squares: npt.NDArray[np.uint8]) -> npt.NDArray[np.float32]:
        """Embeddings (n, 128) of RGB squares (n, s, s, 3) made by `letterbox`, in portions that fit a cache."""
        portions = [to_tensor(squares[start : start + 256]) for start in range(0, len(squares), 256)]
        return np.concatenate([self._model.encode_image(one, normalize=True).float().numpy() for one in portions])

    @torch.inference_mode()
    def embed_text(self, texts: Sequence[str]) -> npt.NDArray[np.float32]:
        """Embeddings (n, 128) of phrases such as "red bottle"."""
        if not texts:
            return np.zeros((0, self.config.embed_dim), np.float32)
        return self._model.encode_text(tokenize(texts, self.config), normalize=True).float().numpy()


def load_model(path: Path) -> tuple[Any, ClipConfig]:
    """The bare open_clip model at `path` (.safetensors, its .json beside it) and its configuration.

    Raises FileNotFoundError if either file is missing.
    """
    config = read_config(path)
    model = build(config)
    model.load_state_dict(load_file(path), strict=True)
    return model, config


def load(path: Path) -> SmallClip:
    """Load the model at `path` for use; raises FileNotFoundError if one of its two files is missing."""
    return SmallClip(*load_model(path))
