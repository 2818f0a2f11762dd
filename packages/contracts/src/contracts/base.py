"""The one base every message shares, and the field types that recur in them."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field


class Message(BaseModel):
    """Immutable; unknown fields are an error, so that both sides cannot drift apart; NaN and infinity are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


StampS = Annotated[float, Field(ge=0.0, description="seconds since the Unix epoch (simulated time counts from 0)")]
NO_CONTROL_CHARACTERS = r"^[^\x00-\x1f\x7f-\x9f]*$"
Label = Annotated[
    str,
    Field(
        min_length=1,
        max_length=64,
        pattern=NO_CONTROL_CHARACTERS,
        description="object class, lower case, e.g. 'bottle'",
    ),
]
Confidence = Annotated[float, Field(ge=0.0, le=1.0)]
BboxXyxy = Annotated[
    tuple[float, float, float, float],
    Field(description="x_min, y_min, x_max, y_max in pixels of the frame the message names"),
]
SIGMA_M_MAX = 1e6
SigmaM = Annotated[float, Field(ge=0.0, le=SIGMA_M_MAX)]
"""A standard deviation, whose square is far from an overflow."""
ImageSidePx = Annotated[int, Field(ge=1, le=8192, description="pixels")]
