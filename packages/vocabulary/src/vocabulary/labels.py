"""What people call the things a detector knows: labels, plurals and synonyms. Pure."""

from contracts.coco import COCO_LABELS

PLURALS: dict[str, str] = {"knives": "knife", "mice": "mouse", "sheep": "sheep", "glasses": "wine glass"}
SAME: dict[str, str] = {
    "mug": "cup", "plant": "potted plant", "sofa": "couch", "television": "tv", "telly": "tv", "phone": "cell phone",
    "mobile": "cell phone", "fridge": "refrigerator", "bag": "handbag", "table": "dining table", "bike": "bicycle",
    "teddy": "teddy bear", "computer": "laptop", "glass": "wine glass", "racket": "tennis racket",
    "ball": "sports ball",
}  # fmt: skip


def label_in(text: str) -> str | None:
    """The longest COCO label, synonym or plural said; none where no such word is."""
    said = f" {text} "
    candidates = {label: label for label in COCO_LABELS} | PLURALS | SAME
    for name in sorted(candidates, key=len, reverse=True):
        if f" {name} " in said or f" {name}s " in said or f" {name}es " in said:
            return candidates[name]
    return None
