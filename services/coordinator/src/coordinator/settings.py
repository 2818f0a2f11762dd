"""Settings from the environment, prefix COORDINATOR_; the mission's own numbers are `core.rules.Policy`."""

from pathlib import Path
from urllib.parse import unquote

from pydantic import Field, field_validator
from pydantic_settings import SettingsConfigDict

from coordinator.core.rules import Policy
from mesh.settings import Port, ServiceSettings

SQLITE = ("sqlite:///", "sqlite+aiosqlite:///")
"""The second as it was written when a driver of its own read the file."""


class Settings(Policy, ServiceSettings):
    """E.g. COORDINATOR_PORT, COORDINATOR_ROBOT_BRIDGE_URL, COORDINATOR_COVERAGE_RULE=lawnmower."""

    model_config = SettingsConfigDict(env_prefix="COORDINATOR_", frozen=True, extra="ignore")

    port: Port = 8001
    inference_url: str = Field(default="http://127.0.0.1:8002", description="of the inference service")
    memory_url: str = Field(default="http://127.0.0.1:8003", description="of the memory service")
    robot_bridge_url: str = Field(default="http://127.0.0.1:8004", description="of the bridge to the robot")

    tick_period_s: float = Field(
        default=0.1, gt=0.0, le=1.0, description="between two looks of the mission at its deadlines"
    )
    state_period_s: float = Field(default=0.4, gt=0.0, le=0.5, description="mission.state at least this often")
    robot_state_age_s_max: float = Field(default=2.0, gt=0.0, description="an older robot.state is not believed")
    goal_poll_s: float = Field(
        default=1.0, gt=0.0, description="between two questions about an open goal, where the bus is silent"
    )
    heartbeat_s: float = Field(
        default=0.1, gt=0.0, le=0.2, description="between two heartbeats of the session with the bridge"
    )
    reconnect_s: float = Field(default=0.5, gt=0.0, description="before a lost session is opened again")
    parse_timeout_s: float = Field(default=20.0, gt=0.0, description="for inference to read a command")
    recall_timeout_s: float = Field(default=3.0, gt=0.0, description="for memory to name places")
    call_timeout_s: float = Field(default=5.0, gt=0.0, description="for any other call")
    body_bytes_max: int = Field(default=100_000, ge=1000, description="largest request body; a larger one gets 413")
    celebrate: bool = Field(default=True, description="spin and play after a find")

    database_url: str = Field(default="sqlite:///coordinator.db", description="sqlite:///FILE, the history of missions")
    busy_timeout_s: float = Field(default=2.0, gt=0.0, description="for a locked database file")
    flush_s: float = Field(default=0.3, ge=0.0, description="what is written is on disk this long afterwards, at most")
    missions_kept: int = Field(default=5_000, ge=1, description="in the history; the oldest leave")
    events_kept: int = Field(default=500_000, ge=100, description="lines of all timelines together; the oldest leave")
    recordings_kept: int = Field(default=200, ge=0, description="missions whose recording and pictures are kept")
    restore_bytes_max: int = Field(
        default=4_000_000_000, ge=1_000, le=1_000_000_000_000, description="largest history that can be restored"
    )

    exploration_s: float = Field(
        default=600.0, gt=0.0, le=800.0, description="an exploration drives home after so long"
    )
    exploration_model: str = Field(
        default="", max_length=100, description="of Ollama, chooses where an exploration goes; '' = the frontiers lead"
    )
    exploration_model_url: str = Field(default="http://127.0.0.1:11434", description="the Ollama server of that model")
    exploration_pictures: bool = Field(
        default=False, description="show that model the camera's newest picture: for models that see"
    )
    exploration_calls_max: int = Field(default=300, ge=1, description="of the model in one exploration")
    exploration_tokens_max: int = Field(default=300_000, ge=1, description="of the model in one exploration")
    exploration_waited_s_max: float = Field(
        default=1800.0, gt=0.0, description="that one exploration waits for the model in all"
    )

    queue_max: int = Field(default=20, ge=1, le=50, description="missions that may wait")
    battery_low_percent: float = Field(default=20.0, ge=0.0, le=100.0, description="below: no mission, and to the dock")
    battery_period_s: float = Field(
        default=30.0, gt=0.0, description="between two looks at the battery while no mission runs"
    )
    dock_again_s: float = Field(default=300.0, gt=0.0, description="after a docking that failed")
    looks_to_memory: bool = Field(default=True, description="tell memory what is seen during a mission")
    reason_timeout_s: float = Field(default=17.0, gt=0.0, description="for inference to phrase an answer")

    @field_validator("database_url")
    @classmethod
    def _names_a_file(cls, url: str) -> str:
        named = url.partition(":///")[2]
        if not url.startswith(SQLITE) or "?" in url or named in {"", ":memory:"}:
            raise ValueError("must name a file, as in sqlite:///coordinator.db; a '?' in its name is written %3F")
        return url

    @property
    def database_file(self) -> Path:
        return Path(unquote(self.database_url.partition(":///")[2]))

    @property
    def exploration_file(self) -> Path:
        """Beside the history: what explorations know of each home."""
        return self.database_file.with_name("exploration.db")
