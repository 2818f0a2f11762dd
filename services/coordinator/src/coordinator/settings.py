"""Settings from the environment, prefix COORDINATOR_; the mission's own numbers are `core.rules.Rules`."""

from pathlib import Path
from urllib.parse import unquote

from pydantic import Field, field_validator
from pydantic_settings import BaseSettings, SettingsConfigDict

from coordinator.core.rules import Rules

SQLITE = ("sqlite:///", "sqlite+aiosqlite:///")


class Settings(Rules, BaseSettings):
    """E.g. COORDINATOR_PORT, COORDINATOR_ROBOT_BRIDGE_URL, COORDINATOR_COVERAGE_RULE=lawnmower."""

    model_config = SettingsConfigDict(env_prefix="COORDINATOR_", frozen=True, extra="ignore")

    host: str = "127.0.0.1"
    port: int = Field(default=8001, ge=1, le=65535)
    redis_url: str = "redis://127.0.0.1:6379/0"
    inference_url: str = "http://127.0.0.1:8002"
    memory_url: str = "http://127.0.0.1:8003"
    robot_bridge_url: str = "http://127.0.0.1:8004"

    tick_period_s: float = Field(default=0.1, gt=0.0, le=1.0)
    state_period_s: float = Field(default=0.4, gt=0.0, le=0.5, description="mission.state at least this often")
    robot_state_age_s_max: float = Field(default=2.0, gt=0.0)
    goal_poll_s: float = Field(default=1.0, gt=0.0)
    heartbeat_s: float = Field(default=0.1, gt=0.0, le=0.2)
    reconnect_s: float = Field(default=0.5, gt=0.0)
    parse_timeout_s: float = Field(default=20.0, gt=0.0)
    recall_timeout_s: float = Field(default=3.0, gt=0.0)
    call_timeout_s: float = Field(default=5.0, gt=0.0)
    body_bytes_max: int = Field(default=100_000, ge=1000)
    celebrate: bool = True

    database_url: str = "sqlite+aiosqlite:///coordinator.db"
    busy_timeout_s: float = Field(default=2.0, gt=0.0)
    flush_s: float = Field(default=0.3, ge=0.0, description="what is written is on disk this long afterwards, at most")
    missions_kept: int = Field(default=5_000, ge=1)
    events_kept: int = Field(default=500_000, ge=100)
    recordings_kept: int = Field(default=200, ge=0, description="missions whose recording and pictures are kept")

    queue_max: int = Field(default=20, ge=1, le=50)
    battery_low_percent: float = Field(default=20.0, ge=0.0, le=100.0, description="below: no mission, and to the dock")
    battery_period_s: float = Field(default=30.0, gt=0.0)
    dock_again_s: float = Field(default=300.0, gt=0.0, description="after a docking that failed")
    looks_to_memory: bool = True
    look_timeout_s_memory: float = Field(default=2.0, gt=0.0)
    reason_timeout_s: float = Field(default=15.0, gt=0.0)

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
