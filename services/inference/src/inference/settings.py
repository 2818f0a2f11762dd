"""Settings of the inference service, from the environment (prefix INFERENCE_)."""

from enum import StrEnum
from pathlib import Path

from pydantic import Field
from pydantic_settings import SettingsConfigDict

from inference.language.language_settings import LanguageSettings
from mesh.settings import Port, ServiceSettings


class ModelSet(StrEnum):
    """Which weights go together."""

    SIM = "sim"
    """Small weights of our own, trained on renders of the simulated home."""
    COCO = "coco"
    """YOLOv8n on COCO and CLIP ViT-B/32: what a real robot uses."""


class Backend(StrEnum):
    """What runs the detector's weights."""

    AUTO = "auto"
    """The fastest of those installed, measured once on this machine."""
    TORCH = "torch"
    ONNX = "onnx"
    OPENVINO = "openvino"


class Precision(StrEnum):
    """In what numbers the large image-text model counts."""

    AUTO = "auto"
    """The faster of the two, measured at load."""
    FP32 = "fp32"
    BF16 = "bf16"


DETECTOR_PATHS = {ModelSet.SIM: Path("sim/weights/detector.pt"), ModelSet.COCO: Path("models/yolov8n.pt")}
CLIP_PATHS = {ModelSet.SIM: Path("sim/weights/clip.safetensors"), ModelSet.COCO: Path("models/ViT-B-32.safetensors")}


class Settings(LanguageSettings, ServiceSettings):
    """Frozen; every number carries its unit in its name. Paths are relative to the working directory."""

    model_config = SettingsConfigDict(
        env_prefix="INFERENCE_", env_ignore_empty=True, frozen=True, protected_namespaces=()
    )

    port: Port = 8002
    robot_bridge_url: str = Field(default="http://127.0.0.1:8004", description="of the bridge to the robot")

    model_set: ModelSet = Field(
        default=ModelSet.SIM, description="which weights: sim for the simulator, coco for a real robot"
    )
    detector_path: Path | None = Field(default=None, description="any COCO YOLO, or its export; none = the set's own")
    detector_backend: Backend = Field(default=Backend.AUTO, description="auto, torch, onnx or openvino")
    detector_confidence_min: float | None = Field(default=None, ge=0.01, le=1.0, description="none = the model's own")
    detector_boxes_max: int = Field(default=100, ge=1, le=300, description="boxes in a frame; the surest are kept")
    clip_path: Path | None = Field(default=None, description="none = the model set's own")
    clip_threshold: float | None = Field(default=None, description="none = the model's own, measured one")
    clip_precision: Precision = Field(default=Precision.AUTO, description="auto, fp32 or bf16, for ViT-B/32 and larger")
    colour_margin: float | None = Field(default=None, description="cosine by which a colour must lead; none = model's")
    vote_margin: float | None = Field(default=None, description="the same for the CLIP vote; none = model's")
    colour_crops_max: int | None = Field(default=None, ge=0, description="crops a frame whose colour is asked for")
    imgsz: int | None = Field(
        default=None,
        ge=32,
        le=1280,
        multiple_of=32,
        description="px, the detector's input side; none = the model's own",
    )
    exports_dir: Path = Field(default=Path("out/exports"), description="where exports of the detector are kept")
    export_timeout_s: float = Field(
        default=300.0, gt=0.0, le=3600.0, description="to export the detector, on first use"
    )
    model_threads: int = Field(default=1, ge=1, le=64, description="a model; more than one only on idle cores")
    waiting_max: int = Field(default=16, ge=1, le=256, description="calls that may wait for the models")

    rest_rate_hz: float = Field(default=2.0, gt=0.0, le=60.0, description="of detection while nothing is pursued")
    fast_rate_hz: float = Field(default=5.0, gt=0.0, le=60.0, description="of detection while centering and driving up")
    frame_width_px: int = Field(default=0, ge=0, le=4096, description="0 = frames are kept as they come")
    frame_height_px: int = Field(default=0, ge=0, le=4096, description="0 = in proportion to the width")
    jpeg_quality: int = Field(default=60, ge=1, le=100, description="of annotated pictures")
    annotated_width_px: int = Field(default=500, ge=0, le=2000, description="0 = as wide as the frame")
    stream_viewers_max: int = Field(default=8, ge=0, le=100, description="of the annotated stream; one more gets 503")
    frame_wait_s: float = Field(default=2.0, gt=0.0, le=10.0, description="for the next frame of the bridge")
    frame_age_max_s: float = Field(default=3.0, gt=0.0, description="older than this, frames do not flow")
    clock_restarted_after_s: float = Field(
        default=5.0, gt=0.0, description="without a newer frame, the robot's clock may have started again: any will do"
    )
    localize_timeout_s: float = Field(
        default=0.3, gt=0.0, le=5.0, description="detections are published without places where these take longer"
    )
    spotted_period_s: float = Field(default=0.5, ge=0.0, description="shortest time between two vision.object_spotted")

    validate_frame_wait_s: float = Field(default=3.0, gt=0.0, le=10.0, description="for a frame to vote on")

    @property
    def detector_file(self) -> Path:
        return self.detector_path or DETECTOR_PATHS[self.model_set]

    @property
    def clip_file(self) -> Path:
        return self.clip_path or CLIP_PATHS[self.model_set]
