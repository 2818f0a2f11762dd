"""The three votes of requirement A11, and what they come to. Pure."""

from collections.abc import Sequence
from dataclasses import dataclass

from contracts.vision import Detection, Verdict, Vote

VOTES_NEEDED = 2


@dataclass(frozen=True, slots=True)
class Decision:
    confirmed: bool
    reason: str
    by_single_vote: bool = False


def decide(votes: Sequence[Vote], *, allow_single_vote: bool = False) -> Decision:
    """Confirmed when two voters say yes; fewer than two never confirm, unless the caller allows one that is alone."""
    yes = [vote.voter for vote in votes if vote.verdict is Verdict.YES]
    no = [vote.voter for vote in votes if vote.verdict is Verdict.NO]
    silent = [vote.voter for vote in votes if vote.verdict is Verdict.ABSTAIN]
    tail = f"; {_names(silent)} abstained" if silent else ""
    if len(yes) >= VOTES_NEEDED:
        against = f", {_names(no)} disagreed" if no else ""
        return Decision(True, f"{_names(yes)} agree{against}{tail}")
    if allow_single_vote and len(yes) == 1 and not no:
        return Decision(True, f"only {_names(yes)} could vote, which was allowed{tail}", by_single_vote=True)
    if len(yes) + len(no) < VOTES_NEEDED:
        return Decision(False, f"only {len(yes) + len(no)} of {len(votes)} could vote, {VOTES_NEEDED} are needed{tail}")
    said_yes = f"only {_names(yes)} agreed" if yes else "nobody agreed"
    return Decision(False, f"{said_yes}, {_names(no)} disagreed{tail}")


def detector_vote(found: Detection | None, *, label: str, threshold: float, model: str, took_ms: float) -> Vote:
    """Yes when the detector sees the class in the frame (at the box that is meant)."""
    if found is None:
        reason = f"no {label} in the frame"
        return Vote(
            voter="detector", verdict=Verdict.NO, threshold=threshold, model=model, took_ms=took_ms, reason=reason
        )
    return Vote(
        voter="detector",
        verdict=Verdict.YES,
        score=found.confidence,
        threshold=threshold,
        model=model,
        took_ms=took_ms,
        reason=f"{label} at {found.confidence:.2f}",
    )


@dataclass(frozen=True, slots=True)
class ClipScores:
    """Cosines of one crop: with the description, and with the same description in every other colour."""

    description: str
    score: float
    contrast: dict[str, float]
    """Other colour -> cosine; empty when the description names no colour."""
    frame_score: float | None = None
    """Of the whole frame with the description: told, never voted on."""
    excluded: str = ""
    """The colour it looks like, where a person said that it must not have it."""


def clip_vote(
    scores: ClipScores, *, threshold: float, margin: float, model: str, took_ms: float, note: str = ""
) -> Vote:
    """Yes when the description reaches the model's threshold *and* leads itself in every other colour by `margin`."""
    rival = max(scores.contrast, key=lambda colour: scores.contrast[colour], default=None)
    reaches = scores.score >= threshold
    lead = None if rival is None else scores.score - scores.contrast[rival]
    leads = lead is None or (lead > 0.0 and lead >= margin)
    excluded = f"it looks {scores.excluded}, which was excluded; " if scores.excluded else ""
    compared = f"{excluded}'{scores.description}' {scores.score:.2f}, {threshold:.2f} needed"
    if rival is not None:
        compared += f"; {'next' if leads else 'but'} {rival} {scores.contrast[rival]:.2f}"
        compared += f", a lead of {margin:.2f} needed" if margin and not leads else ""
    return Vote(
        voter="clip",
        verdict=Verdict.YES if reaches and leads and not excluded else Verdict.NO,
        score=scores.score,
        threshold=threshold,
        rival=rival or "",
        rival_score=None if rival is None else scores.contrast[rival],
        frame_score=scores.frame_score,
        model=model,
        took_ms=took_ms,
        reason=compared + (f" ({note})" if note else ""),
    )


def abstain(voter: str, reason: str, *, model: str = "", took_ms: float = 0.0) -> Vote:
    return Vote(voter=voter, verdict=Verdict.ABSTAIN, model=model, took_ms=took_ms, reason=reason)


def _names(voters: Sequence[str]) -> str:
    return " and ".join(voters)
