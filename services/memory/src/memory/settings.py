"""Settings of the memory service, from the environment (prefix MEMORY_)."""

from urllib.parse import urlsplit

from pydantic import Field, field_validator
from pydantic_settings import SettingsConfigDict

from contracts.memory import RecallRule
from mesh.settings import Port, ServiceSettings

SQLITE = "sqlite:///"
POSTGRESQL = "postgresql://"


class Settings(ServiceSettings):
    """Frozen; every number carries its unit in its name. A relative database path starts at the working directory."""

    model_config = SettingsConfigDict(env_prefix="MEMORY_", frozen=True)

    port: Port = 8003
    robot_bridge_url: str = Field(default="http://127.0.0.1:8004", description="for depth and map; empty: do without")
    database_url: str = Field(default=f"{SQLITE}memory.db", description="sqlite:///FILE or postgresql://...")

    excluded_labels: tuple[str, ...] = Field(default=("person",), description="never written, not even to a log")
    confidence_min: float = Field(default=0.30, ge=0.0, le=1.0, description="of detections; what is posted is kept")
    flush_period_s: float = Field(default=1.0, gt=0.0, le=60.0, description="between two writes")
    buffer_max: int = Field(default=5_000, ge=1, le=1_000_000, description="frames that wait for the next flush")
    views_max: int = Field(default=1_000_000, ge=100, description="when full, the views longest not seen are forgotten")
    objects_max: int = Field(default=5_000, ge=10, le=100_000, description="the same of objects")
    retention_days: float = Field(default=400.0, gt=0.0, description="what was last seen so long ago is forgotten")
    lost_retention_days: float = Field(default=30.0, gt=0.0, description="the same of objects that are lost")
    tidy_period_s: float = Field(default=3600.0, gt=0.0, description="between two rounds of forgetting")
    busy_timeout_s: float = Field(default=2.0, gt=0.0, le=30.0, description="how long a write waits for a locked file")
    import_bytes_max: int = Field(
        default=64_000_000, ge=1_000, le=1_000_000_000, description="largest file that can be imported"
    )
    restore_bytes_max: int = Field(
        default=4_000_000_000, ge=1_000, le=1_000_000_000_000, description="largest database that can be restored"
    )

    look_range_m: float = Field(default=2.3, gt=0.3, le=10.0, description="a cup not seen within it was missing")
    senses_timeout_s: float = Field(default=0.5, gt=0.0, le=5.0, description="for depth and map of one frame")

    recall_rule: RecallRule = Field(
        default=RecallRule.BELIEF,
        description="how remembered places are ranked: by belief, or in the plain order of requirement A5",
    )
    candidates_max: int = Field(default=100, ge=1, le=50_000, description="views without an object, of a label")
    views_an_object: int = Field(default=4, ge=1, le=100, description="of which recall chooses where to look from")
    weight_belief: float = Field(
        default=1.0, ge=0.0, le=5.0, description="power in the score of: the belief that it is there; 0 leaves it out"
    )
    weight_agreement: float = Field(
        default=1.0, ge=0.0, le=5.0, description="of the agreement with the colour asked for"
    )
    weight_relation: float = Field(
        default=1.0, ge=0.0, le=5.0, description="of being the label itself, not the memory object"
    )
    weight_confidence: float = Field(default=0.5, ge=0.0, le=5.0, description="of the detector's confidence")
    weight_recency: float = Field(default=0.25, ge=0.0, le=5.0, description="of how lately it was seen")
    weight_travel: float = Field(default=0.25, ge=0.0, le=5.0, description="of the way there")
    weight_again: float = Field(
        default=1.0, ge=0.0, le=5.0, description="of the discount on further views of one object"
    )

    @field_validator("database_url")
    @classmethod
    def _is_known(cls, url: str) -> str:
        if url.startswith(POSTGRESQL):
            server = urlsplit(url)
            if not (server.hostname or "host=" in server.query) or not server.path.strip("/"):
                raise ValueError("must name a server and a database, as in postgresql://atom@localhost/atom")
            return url
        if not url.startswith(SQLITE) or url == SQLITE or "?" in url or ":memory:" in url:
            raise ValueError(f"must name a file, as in {SQLITE}memory.db, or a server: {POSTGRESQL}...")
        return url
