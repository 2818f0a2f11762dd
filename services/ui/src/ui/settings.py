"""Settings from the environment, prefix UI_."""

from pydantic import Field
from pydantic_settings import BaseSettings, SettingsConfigDict


class Settings(BaseSettings):
    """E.g. UI_PORT, UI_COORDINATOR_URL."""

    model_config = SettingsConfigDict(env_prefix="UI_", frozen=True, extra="ignore")

    host: str = "127.0.0.1"
    port: int = Field(default=8080, ge=1, le=65535)
    redis_url: str = "redis://127.0.0.1:6379/0"
    coordinator_url: str = "http://127.0.0.1:8001"
    inference_url: str = "http://127.0.0.1:8002"
    memory_url: str = "http://127.0.0.1:8003"
    robot_bridge_url: str = "http://127.0.0.1:8004"
    body_bytes_max: int = Field(default=20_000, ge=1000)

    call_timeout_s: float = Field(default=5.0, gt=0.0)
    command_timeout_s: float = Field(default=30.0, gt=0.0, description="reading a command may ask a language model")
    dock_timeout_s: float = Field(default=100.0, gt=0.0)
    stop_timeout_s: float = Field(default=1.5, gt=0.0, description="of one try")
    stop_tries: int = Field(default=3, ge=1, le=10)

    state_period_s: float = Field(default=0.5, gt=0.0, description="between two refreshes of the words on the page")
    marker_period_s: float = Field(default=0.2, ge=0.2, description="between two refreshes of the robot on the map")
    health_period_s: float = Field(default=3.0, gt=0.0, description="services are asked only while a page is open")
    map_period_s: float = Field(default=10.0, gt=0.0)
    silence_s_max: float = Field(default=2.0, gt=0.0, description="past this, facts count as old and are asked for")
    events_kept: int = Field(default=300, ge=10, le=1000)
    trail_points_max: int = Field(default=2000, ge=100)
    trail_step_m: float = Field(default=0.05, gt=0.0)
