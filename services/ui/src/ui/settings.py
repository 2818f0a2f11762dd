"""Settings from the environment, prefix UI_."""

from pathlib import Path

from nicegui.language import Language
from pydantic import Field
from pydantic_settings import SettingsConfigDict

from mesh.settings import Port, ServiceSettings


class Settings(ServiceSettings):
    """E.g. UI_PORT, UI_COORDINATOR_URL."""

    model_config = SettingsConfigDict(env_prefix="UI_", frozen=True, extra="ignore")

    port: Port = 8080
    coordinator_url: str = Field(default="http://127.0.0.1:8001", description="of the coordinator")
    inference_url: str = Field(default="http://127.0.0.1:8002", description="of the inference service")
    memory_url: str = Field(default="http://127.0.0.1:8003", description="of the memory service")
    robot_bridge_url: str = Field(default="http://127.0.0.1:8004", description="of the bridge to the robot")
    speech_url: str = Field(default="", description="of the speech service; empty = the page neither hears nor speaks")
    prefix: str = Field(
        default="", description="of the page behind a proxy that serves it below a path and cannot say so, e.g. /robot"
    )
    session_s: int = Field(
        default=43_200, ge=60, le=2_592_000, description="a log-in lasts; then it is asked for again"
    )
    body_bytes_max: int = Field(default=20_000, ge=1000, description="largest request body; a larger one gets 413")
    import_bytes_max: int = Field(default=50_000_000, ge=1000, description="of a memory taken back from a file")

    call_timeout_s: float = Field(default=5.0, gt=0.0, description="of an ordinary call")
    command_timeout_s: float = Field(default=30.0, gt=0.0, description="reading a command may ask a language model")
    speak_timeout_s: float = Field(default=15.0, gt=0.0, description="of an answer read aloud")
    dock_timeout_s: float = Field(default=100.0, gt=0.0, description="for the robot to reach its dock")
    stop_timeout_s: float = Field(default=1.5, gt=0.0, description="of one try")
    stop_tries: int = Field(default=3, ge=1, le=10, description="of one emergency stop")

    state_period_s: float = Field(default=0.5, gt=0.0, description="between two refreshes of the words on the page")
    camera_fps_max: float = Field(default=12.0, gt=0.0, le=30.0, description="pictures a second, to any one viewer")
    scene_period_s: float = Field(default=0.1, ge=0.05, description="between two refreshes of the map's marks")
    scan_period_s: float = Field(default=0.2, ge=0.05, description="the laser is asked for only while a map is open")
    health_period_s: float = Field(default=3.0, gt=0.0, description="services are asked only while a page is open")
    map_period_s: float = Field(default=10.0, gt=0.0, description="between two looks at the map")
    memory_period_s: float = Field(default=4.0, gt=0.0, description="between two looks at what is remembered")
    belief_period_s: float = Field(
        default=1.0, gt=0.0, description="what a search holds probable is asked for only while a page shows it"
    )
    plan_period_s: float = Field(default=3.0, gt=0.0, description="the path to an open goal is asked for this often")
    silence_s_max: float = Field(default=2.0, gt=0.0, description="past this, facts count as old and are asked for")
    transfer_timeout_s: float = Field(default=60.0, gt=0.0, description="of an export or import of the memory")
    goal_timeout_s: float = Field(default=120.0, gt=0.0, description="of a drive to a place clicked on the map")
    teleop_speed_share: float = Field(default=0.8, gt=0.0, le=1.0, description="fastest drive by hand, of top speed")
    teleop_turn_share: float = Field(default=0.65, gt=0.0, le=1.0, description="fastest turn by hand, of the fastest")
    teleop_lease_s: float = Field(default=0.3, gt=0.0, le=0.5, description="what one word of the stick is worth")
    teleop_delay_s_max: float = Field(default=0.3, gt=0.0, description="a word longer on its way is worth nothing")
    texts_file: Path | None = Field(default=None, description="TOML of English = translation; none = English")
    language: Language = Field(default="en-US", description="of the texts, for screen readers and speech")
    album_pictures_max: int = Field(default=400, ge=0, le=10_000, description="moments; of things again as many")
    events_kept: int = Field(default=300, ge=10, le=1000, description="lines of the timeline")
    trail_points_max: int = Field(default=2000, ge=100, description="of the path driven; thinned out beyond")
    trail_step_m: float = Field(default=0.05, gt=0.0, description="between two points of it")
