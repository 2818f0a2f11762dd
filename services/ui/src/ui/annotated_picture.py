"""Draws a kept picture with its boxes, as the browser draws the live one."""

import io
from typing import Final

from PIL import Image, ImageDraw, ImageFont

from ui.frames import Shown

RED: Final = (230, 30, 30)
GREEN: Final = (40, 190, 70)
WIDTH_PX: Final = 500


def annotated(shown: Shown) -> bytes:
    """A JPEG, 500 px wide. Raises `OSError` when the picture cannot be read."""
    image = Image.open(io.BytesIO(shown.frame.jpeg)).convert("RGB")
    image = image.resize((WIDTH_PX, max(1, round(WIDTH_PX * image.height / image.width))))
    draw, font = ImageDraw.Draw(image), ImageFont.load_default(15)
    for box in shown.about["boxes"]:
        colour = RED if box["target"] else GREEN
        left, top, right, bottom = box["at"]
        corners = (left * image.width, top * image.height, right * image.width, bottom * image.height)
        draw.rectangle(corners, outline=colour, width=3)
        at = (corners[0] + 4, max(2.0, corners[1] - 19))
        words = draw.textbbox(at, box["text"], font=font)
        draw.rectangle((words[0] - 4, words[1] - 2, words[2] + 4, words[3] + 2), fill=colour)
        draw.text(at, box["text"], fill=(255, 255, 255), font=font)
    out = io.BytesIO()
    image.save(out, "JPEG", quality=80)
    return out.getvalue()
