"""Lets torchvision import beside a CPU build of torch when its own compiled operators cannot load.

The package index serves a torchvision that was linked against CUDA. Beside CPU torch its shared library does not
load, and `import torchvision` stops at "operator torchvision::nms does not exist". ultralytics, open_clip and timm all
import torchvision. Everything they use of it is plain Python except `nms`, so declaring the two operators that are
looked up during the import, and giving `nms` a CPU kernel, is enough. `roi_align` and the image codecs stay absent.

Call `install()` once before the first import of any of those packages. Where the real operators load it does nothing.
"""

import importlib.util
from pathlib import Path

import torch

_registered: list[torch.library.Library] = []


def install() -> bool:
    """Register the stand-in operators if they are needed; says whether they are the ones in use."""
    if _registered:
        return True
    if _real_operators_load():
        return False
    library = torch.library.Library("torchvision", "FRAGMENT")
    library.define("nms(Tensor dets, Tensor scores, float iou_threshold) -> Tensor")
    library.define("qnms(Tensor dets, Tensor scores, float iou_threshold) -> Tensor")
    library.impl("nms", non_maximum_suppression, "CPU")
    _registered.append(library)  # the registration lives as long as this object

    from torchvision import extension

    extension._has_ops = lambda: True
    extension._check_cuda_version = lambda: -1
    return True


def non_maximum_suppression(boxes: torch.Tensor, scores: torch.Tensor, iou_threshold: float) -> torch.Tensor:
    """Indices of the boxes kept, best score first; the contract of `torchvision.ops.nms`.

    `boxes` is (n, 4) as x_min, y_min, x_max, y_max; `scores` is (n,). A box is dropped when its intersection over
    union with a better, kept one exceeds `iou_threshold`.
    """
    order = torch.argsort(scores, descending=True, stable=True)
    overlap = _iou_matrix(boxes[order].float()) > iou_threshold
    dropped = torch.zeros(len(order), dtype=torch.bool)
    kept: list[int] = []
    for rank in range(len(order)):
        if dropped[rank]:
            continue
        kept.append(rank)
        dropped |= overlap[rank]
    return order[torch.tensor(kept, dtype=torch.long)]


def _iou_matrix(boxes: torch.Tensor) -> torch.Tensor:
    top_left = torch.maximum(boxes[:, None, :2], boxes[None, :, :2])
    bottom_right = torch.minimum(boxes[:, None, 2:], boxes[None, :, 2:])
    intersection = (bottom_right - top_left).clamp(min=0).prod(dim=2)
    area = (boxes[:, 2:] - boxes[:, :2]).prod(dim=1)
    return intersection / (area[:, None] + area[None, :] - intersection)


def _real_operators_load() -> bool:
    spec = importlib.util.find_spec("torchvision")
    if spec is None or spec.origin is None:
        return True  # nothing to stand in for: the import itself will say that torchvision is missing
    for library in Path(spec.origin).parent.glob("_C*.so"):
        try:
            torch.ops.load_library(str(library))
        except OSError:
            continue
        return True
    return False
