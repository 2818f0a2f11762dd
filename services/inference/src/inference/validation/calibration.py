"""What a vote is worth: log-odds measured on held-out pictures (`bench.calibration` writes the table)."""

from collections.abc import Sequence
from pathlib import Path

import structlog
from pydantic import BaseModel, ConfigDict, Field

from contracts.base import BboxXyxy
from contracts.vision import LOG_ODDS_MAX, Verdict, Vote

log = structlog.get_logger()

FILE = "calibration.json"
"""Stands beside the weights it was measured for."""


class Curve(BaseModel):
    """One voter's log p(score | it is the target) / p(score | it is not), for boxes from one size upwards."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    side_share_min: float = Field(ge=0.0, le=1.0, description="shorter side of the box over the width of the picture")
    intercept: float
    slope: float = Field(ge=0.0, description="never falls: a better score is no worse evidence")
    lowest: float = Field(ge=-LOG_ODDS_MAX, le=0.0, description="no score says less: so few pictures cannot")
    highest: float = Field(ge=0.0, le=LOG_ODDS_MAX, description="no score says more")
    unseen: float | None = Field(
        default=None,
        ge=-LOG_ODDS_MAX,
        le=LOG_ODDS_MAX,
        description="without a score: the detector saw none of the kind",
    )

    def log_odds(self, score: float) -> float:
        return min(max(self.intercept + self.slope * score, self.lowest), self.highest)


class VoterCurves(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")

    model: str = Field(description="the model it was measured for; another one's votes stay without log-odds")
    sha256: str = Field(description="of its weights")
    by_size: tuple[Curve, ...] = Field(min_length=1, max_length=8, description="from the smallest side upwards")

    def at(self, side_share: float) -> Curve:
        return [curve for curve in self.by_size if curve.side_share_min <= side_share][-1]


class Calibration(BaseModel):
    """The table: empty where nobody measured these weights."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    detector: VoterCurves | None = None
    clip_colour: VoterCurves | None = Field(default=None, description="of a phrase that names a colour")
    clip_kind: VoterCurves | None = Field(default=None, description="of one that names none")

    def weighed(self, votes: Sequence[Vote], bbox: BboxXyxy | None, width_px: int) -> tuple[Vote, ...]:
        """The votes with their log-odds, where the table knows the model that voted."""
        return tuple(vote.model_copy(update={"log_odds": self._log_odds(vote, bbox, width_px)}) for vote in votes)

    def _log_odds(self, vote: Vote, bbox: BboxXyxy | None, width_px: int) -> float | None:
        curves = {"detector": self.detector, "clip": self.clip_colour if vote.rival else self.clip_kind}.get(vote.voter)
        if bbox is None or vote.verdict is Verdict.ABSTAIN or curves is None or curves.model != vote.model:
            return None
        curve, score = curves.at(side_share(bbox, width_px)), statistic(vote)
        if score is None:
            return curve.unseen
        excluded = vote.verdict is Verdict.NO and score >= 0.0  # it reaches, but in a colour it must not have
        return round(curve.lowest if excluded else curve.log_odds(score), 3)


UNMEASURED = Calibration()


def statistic(vote: Vote) -> float | None:
    """How far a vote is on the side of yes: over its threshold, and over the next best colour; the worse of the two."""
    if vote.score is None:
        return None
    over = vote.score - (vote.threshold or 0.0)
    return over if vote.rival_score is None else min(over, vote.score - vote.rival_score)


def side_share(bbox: BboxXyxy, width_px: int) -> float:
    return min(bbox[2] - bbox[0], bbox[3] - bbox[1]) / max(1, width_px)


def read_calibration(folder: Path) -> Calibration:
    """The table in the folder of the weights, or an empty one: votes go without log-odds then."""
    path = folder / FILE
    try:
        return Calibration.model_validate_json(path.read_text()) if path.is_file() else UNMEASURED
    except (OSError, ValueError) as error:
        log.warning("the votes go uncalibrated", path=str(path), problem=str(error))
        return UNMEASURED
