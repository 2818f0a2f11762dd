"""What a search by belief holds probable, as a page draws it: a grid of probabilities, and the view chosen by it."""

from enum import StrEnum

from pydantic import Field, model_validator

from contracts.base import Message, StampS
from contracts.geometry import Pose2D

PROBABILITY_CELLS_MAX = 1_000_000
"""150 m by 150 m in cells of 15 cm; what is larger is told in larger cells."""
PROBABILITY_DECADES = 4.0
"""The least probable cell that is told is 10^-4 times as probable as the most probable one."""
_BASE64_MAX = 1_400_000
"""Of so many bytes that zlib could not make fewer."""


class ProbabilityGrid(Message):
    """Row 0 at the origin, as in `contracts.robot.Map`; `geometry.probability_grids` reads and makes it."""

    width: int = Field(ge=1, le=PROBABILITY_CELLS_MAX)
    height: int = Field(ge=1, le=PROBABILITY_CELLS_MAX)
    resolution_m: float = Field(gt=0.0, le=1000.0, description="a cell's side")
    origin: Pose2D = Field(description="of the corner of the first cell in map; may be turned")
    peak: float = Field(ge=0.0, le=1.0, description="probability of the most probable cell")
    levels_base64: str = Field(
        max_length=_BASE64_MAX,
        description="width*height uint8 levels, zlib-compressed, base64: 255 is `peak`, 1 is `peak` / 10^4, even steps "
        "of the logarithm between; 0 is less",
    )

    @model_validator(mode="after")
    def _is_not_too_large(self) -> "ProbabilityGrid":
        if self.width * self.height > PROBABILITY_CELLS_MAX:
            raise ValueError(f"a grid of probabilities has no more than {PROBABILITY_CELLS_MAX} cells")
        return self


class ChosenView(Message):
    """Where a search looks next, and what that is worth."""

    pose: Pose2D = Field(description="of the robot in map; its yaw is the first heading")
    headings: tuple[float, ...] = Field(max_length=100, description="of the looks there, rad in map, one after another")
    gain: float = Field(ge=0.0, le=1.0, description="probability that it shows the target")
    seconds: float = Field(ge=0.0, description="that it takes: the drive, the turns and the looks")


class SearchBelief(Message):
    """`GET /missions/{id}/belief`: where the target probably is, after every look so far. All cells and `absent` sum to
    one.
    """

    stamp_s: StampS
    mission_id: str = Field(max_length=64)
    map_id: str | None = Field(default=None, max_length=40, description="the home it is of; none = not known")
    grid: ProbabilityGrid
    absent: float = Field(ge=0.0, le=1.0, description="probability that the target is nowhere on this map")
    view: ChosenView | None = Field(default=None, description="chosen last; none: nothing was worth a look any more")
    why: str = Field(default="", max_length=500, description="it was chosen, for a person")


class NoBelief(StrEnum):
    """Why a mission has no belief to tell (`code` of the 404)."""

    NOT_BEGUN = "not_begun"
    """It waits in the queue."""
    ENDED = "ended"
    ANOTHER_RULE = "another_rule"
    """It does not search by belief."""
    NOTHING_CHOSEN = "nothing_chosen"
    """It has not come to its first choice yet."""
