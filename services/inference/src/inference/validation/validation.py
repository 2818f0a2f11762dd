"""Three votes on one frame (requirement A11): gathers what each voter says, and lets `votes.decide` judge."""

import asyncio
import time
from dataclasses import dataclass, field

from prometheus_client import Counter

from contracts.base import BboxXyxy
from contracts.vision import Detection, Target, ValidateRequest, Validation, Verdict, Vote
from geometry.boxes import area
from inference.boxes import meant_box
from inference.colours import phrase, with_colour
from inference.perception.annotate import to_jpeg
from inference.perception.embeddings import NoEmbeddingError
from inference.perception.models import Models, judged_crop
from inference.ports import Camera, Frame, ImageText, RgbImage, VisionLanguageModel
from inference.validation.calibration import UNMEASURED, Calibration
from inference.validation.evidence import Evidence
from inference.validation.votes import VOTES_NEEDED, ClipScores, abstain, clip_vote, decide, detector_vote
from mesh.errors import ServiceTimeoutError, UnavailableError, UnprocessableError, UpstreamError
from mesh.tracing import current_span

VOTES = Counter("inference_votes_total", "votes on a thing", ["voter", "verdict"])
VALIDATIONS = Counter("inference_validations_total", "things judged by votes", ["confirmed"])

VLM_MARGIN = 0.5
"""Share of the longer box side shown round the thing to the vision-language model, which needs surroundings."""
VLM_JPEG_QUALITY = 90


@dataclass(frozen=True)
class Validator:
    camera: Camera
    models: Models
    vlm: VisionLanguageModel | None
    frame_wait_s: float
    vlm_deadline_s: float
    calibration: Calibration = UNMEASURED
    evidence: Evidence = field(default_factory=Evidence)

    async def validate(self, request: ValidateRequest) -> Validation:
        """Votes on the newest frame after `after_stamp_s`.

        Raises `ServiceTimeoutError` when none comes in time, `UnavailableError` without camera or detector.
        """
        self.models.detector()
        frame = await self.fresh_frame(request.after_stamp_s)
        if request.bbox_xyxy is not None:
            require_box(request.bbox_xyxy)
        sight = await self.models.see(frame.jpeg, request.target)
        image, look = sight.image, sight.look
        meant = meant_box(look.detections, request.target, request.bbox_xyxy)
        detector = self.models.detector()
        first = detector_vote(
            meant,
            label=request.target.label,
            threshold=detector.threshold,
            model=detector.name,
            took_ms=look.took_ms,
        )
        bbox = meant.bbox_xyxy if meant is not None else request.bbox_xyxy
        second = await self._ask_clip(image, bbox, request.target, meant)
        third = (
            abstain("vlm", "not asked: the robot drives on")
            if request.moving
            else await self._ask_vlm(image, bbox, request.target, (first, second))
        )
        votes = (first, second, third)
        decision = decide(votes, allow_single_vote=request.allow_single_vote)
        _tell(votes, confirmed=decision.confirmed)
        return Validation(
            id=self.evidence.keep(self._judged(image, bbox)),
            confirmed=decision.confirmed,
            votes=self.calibration.weighed(votes, bbox, image.shape[1]),
            by_single_vote=decision.by_single_vote,
            stamp_s=frame.stamp_s,
            image_width_px=image.shape[1],
            image_height_px=image.shape[0],
            bbox_xyxy=bbox,
            reason=decision.reason,
        )

    def _judged(self, image: RgbImage, bbox: BboxXyxy | None) -> RgbImage:
        """The crop that the image-text model was shown; without one, the box and what is round it."""
        clip = self.models.clip_or_none()
        if clip is not None:
            return judged_crop(clip, image, bbox)
        return image if bbox is None else surroundings(image, bbox)

    async def fresh_frame(self, after_s: float | None) -> Frame:
        frame = await self.camera.newest(after_s=after_s, wait_s=self.frame_wait_s)
        if frame is None or (after_s is not None and frame.stamp_s <= after_s):
            raise ServiceTimeoutError("robot_bridge", f"no camera frame newer than {after_s} in {self.frame_wait_s} s")
        return frame

    async def _ask_clip(self, image: RgbImage, bbox: BboxXyxy | None, target: Target, meant: Detection | None) -> Vote:
        clip = self.models.clip_or_none()
        if clip is None:
            return abstain("clip", self.models.problem or "no image-text model")
        description, unknown = clip.known(target.description)
        said = target.colour
        if not description or (said is not None and not set(unknown).isdisjoint(said.spellings)):
            return abstain(
                "clip", f"does not know the word {', '.join(unknown) or target.description}", model=clip.name
            )
        if said is not None and said not in clip.colours:
            return abstain("clip", f"was never taught what {said} looks like", model=clip.name)
        if said is None:  # whatever its colour: the best of the description in each colour, and in none
            texts = [description, *(f"{colour} {description}" for colour in clip.colours)]
            asked, contrast = [phrase(clip.template, text) for text in texts], list[str]()
        else:
            contrast = [colour for colour in clip.colours if colour is not said and colour not in description.split()]
            texts = [description, *(with_colour(description, said, other) for other in contrast)]
            asked = [phrase(clip.template, text) for text in texts]
        try:
            seen = await self.models.score(image, bbox, asked)
        except NoEmbeddingError as error:
            return abstain("clip", error.detail, model=clip.name)
        best = max(range(len(texts)), key=lambda i: seen.scores[i]) if said is None else 0
        looks = clip.colours[best - 1] if said is None and best else ""
        return clip_vote(
            ClipScores(
                description=texts[best],
                score=seen.scores[best],
                contrast=dict(zip(contrast, seen.scores[1:], strict=False)),
                frame_score=seen.frame_scores[best] if seen.frame_scores else None,
                excluded=looks if looks in target.not_colours else "",
            ),
            threshold=clip.threshold,
            margin=clip.vote_margin,
            model=clip.name,
            took_ms=seen.took_ms,
            note=_note(unknown, bbox, meant, clip),
        )

    async def _ask_vlm(self, image: RgbImage, bbox: BboxXyxy | None, target: Target, others: tuple[Vote, ...]) -> Vote:
        """Asked only while the other two leave it open: it takes seconds, and two votes decide."""
        if self.vlm is None:
            return abstain("vlm", "no vision-language model is configured")
        if sum(vote.verdict is Verdict.YES for vote in others) >= VOTES_NEEDED:
            return abstain("vlm", "not asked: two already agree", model=self.vlm.name)
        if not any(vote.verdict is Verdict.YES for vote in others):
            return abstain("vlm", "not asked: its vote could not confirm any more", model=self.vlm.name)
        jpeg = to_jpeg(image if bbox is None else surroundings(image, bbox), VLM_JPEG_QUALITY)
        began_s = time.perf_counter()
        try:
            async with asyncio.timeout(self.vlm_deadline_s):
                present = await self.vlm.present(jpeg, _asked_for(target))
        except TimeoutError:
            return abstain("vlm", f"past its deadline of {self.vlm_deadline_s:g} s", model=self.vlm.name)
        except (UnavailableError, UpstreamError) as error:
            return abstain("vlm", error.detail, model=self.vlm.name)
        return Vote(
            voter="vlm",
            verdict=Verdict.YES if present else Verdict.NO,
            model=self.vlm.name,
            took_ms=round((time.perf_counter() - began_s) * 1000, 1),
            reason=f"PRESENT: {'yes' if present else 'no'}",
        )


def surroundings(image: RgbImage, bbox: BboxXyxy) -> RgbImage:
    """The box with half its longer side all round; never empty."""
    height_px, width_px = image.shape[:2]
    margin_px = VLM_MARGIN * max(bbox[2] - bbox[0], bbox[3] - bbox[1])
    left, top = (int(min(max(0.0, bbox[i] - margin_px), size - 1)) for i, size in ((0, width_px), (1, height_px)))
    right = int(min(max(left + 1.0, bbox[2] + margin_px), width_px))
    bottom = int(min(max(top + 1.0, bbox[3] + margin_px), height_px))
    return image[top:bottom, left:right]


def require_box(bbox: BboxXyxy) -> None:
    if area(bbox) <= 0.0:
        raise UnprocessableError(f"bbox_xyxy {bbox} is empty: x_min, y_min, x_max, y_max in pixels are expected")


def _tell(votes: tuple[Vote, ...], *, confirmed: bool) -> None:
    """Prometheus, and the trace in which it was asked."""
    VALIDATIONS.labels(str(confirmed).lower()).inc()
    for vote in votes:
        VOTES.labels(vote.voter, vote.verdict.value).inc()
        told = {"voter": vote.voter, "verdict": vote.verdict.value, "took_ms": vote.took_ms}
        current_span().add_event("vote", told)


def _asked_for(target: Target) -> str:
    """The description, and the colours it must not have."""
    unlike = f" that is not {' or '.join(target.not_colours)}" if target.not_colours else ""
    return f"{target.description}{unlike}"


def _note(unknown: tuple[str, ...], bbox: BboxXyxy | None, meant: Detection | None, clip: ImageText) -> str:
    notes = [f"{clip.name} does not know {', '.join(unknown)}"] if unknown else []
    if bbox is None:
        notes.append("judged on the whole frame")
    elif meant is None:
        notes.append("judged on the box that was asked about")
    return "; ".join(notes)
