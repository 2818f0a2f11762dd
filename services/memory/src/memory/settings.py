"""Settings of the memory service, from the environment (prefix MEMORY_)."""

from pydantic import Field, field_validator
from pydantic_settings import BaseSettings, SettingsConfigDict

SQLITE = "sqlite+aiosqlite:///"


class Settings(BaseSettings):
    """Frozen; every number carries its unit in its name. A relative database path starts at the working directory."""

    model_config = SettingsConfigDict(env_prefix="MEMORY_", frozen=True)

    host: str = "127.0.0.1"
    port: int = Field(default=8003, ge=1, le=65535)
    redis_url: str = "redis://127.0.0.1:6379/0"
    database_url: str = f"{SQLITE}memory.db"

    excluded_labels: tuple[str, ...] = Field(default=("person",), description="never written, not even to a log")
    confidence_min: float = Field(default=0.30, ge=0.0, le=1.0, description="of detections; what is posted is kept")
    flush_period_s: float = Field(default=1.0, gt=0.0, le=60.0)
    buffer_max: int = Field(default=10_000, ge=1, le=1_000_000, description="detections that wait for the next flush")
    views_max: int = Field(default=1_000_000, ge=100, description="when full, the views longest not seen are forgotten")
    candidates_max: int = Field(default=2_000, ge=1, le=50_000, description="views a label that recall chooses from")
    busy_timeout_s: float = Field(default=2.0, gt=0.0, le=30.0, description="how long a write waits for a locked file")

    @field_validator("database_url")
    @classmethod
    def _is_a_file(cls, url: str) -> str:
        if not url.startswith(SQLITE) or url == SQLITE or "?" in url or ":memory:" in url:
            raise ValueError(f"must name a file, as in {SQLITE}memory.db")
        return url
