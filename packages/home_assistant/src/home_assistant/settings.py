"""Settings of the way to Home Assistant, from the environment (prefix HOME_ASSISTANT_)."""

from importlib.metadata import version
from pathlib import Path

from pydantic import Field, SecretStr
from pydantic_settings import SettingsConfigDict

from home_assistant.discovery import RobotIdentity
from mesh.settings import ClientSettings

ID = r"^[a-zA-Z0-9_-]+$"
"""What Home Assistant takes for an id in a discovery topic."""
PREFIX = r"^[^#+\x00-\x1f/][^#+\x00-\x1f]*$"


class Settings(ClientSettings):
    """Frozen; every number carries its unit in its name."""

    model_config = SettingsConfigDict(env_prefix="HOME_ASSISTANT_", frozen=True)

    coordinator_url: str = Field(default="http://127.0.0.1:8001", description="of the coordinator")
    robot_bridge_url: str = Field(default="http://127.0.0.1:8004", description="of the bridge to the robot")
    mqtt_host: str = Field(default="127.0.0.1", min_length=1, max_length=253, description="of the MQTT broker")
    mqtt_port: int = Field(default=1883, ge=1, le=65535, description="of the MQTT broker; 8883 is usual with TLS")
    mqtt_username: str | None = Field(default=None, max_length=200, description="at the broker; none = nobody asks")
    mqtt_password: SecretStr | None = Field(default=None, description="at the broker; or in a file")
    mqtt_password_file: Path | None = Field(default=None, description="holds the password at the broker")
    mqtt_tls: bool = Field(default=False, description="the broker's certificate is checked as the machine checks any")
    mqtt_ca_file: Path | None = Field(default=None, description="certificates of who may vouch for the broker, beside")
    discovery_prefix: str = Field(
        default="homeassistant",
        max_length=64,
        pattern=PREFIX,
        description="as Home Assistant has it",
    )
    topic_prefix: str = Field(default="atom", max_length=64, pattern=PREFIX, description="of the robot's own topics")
    robot_id: str = Field(default="atom", max_length=64, pattern=ID, description="of this robot, where there are more")
    robot_name: str = Field(default="ATOM", min_length=1, max_length=64, description="as Home Assistant shows it")
    page_url: str | None = Field(
        default=None, max_length=500, pattern=r"^https?://", description="of the robot's page, linked from its device"
    )
    camera: bool = Field(default=False, description="whether its camera's pictures go to the broker")
    camera_period_s: float = Field(default=2.0, ge=0.2, le=3600.0, description="between two pictures")
    state_period_s: float = Field(default=2.0, ge=0.1, le=60.0, description="between two looks at how the robot does")
    reconnect_s: float = Field(default=5.0, gt=0.0, le=600.0, description="before the next try, without a broker")
    call_timeout_s: float = Field(default=5.0, gt=0.0, description="of an ordinary call")
    command_timeout_s: float = Field(default=30.0, gt=0.0, description="reading a command may ask a language model")
    stop_timeout_s: float = Field(default=1.5, gt=0.0, description="of one try")

    @property
    def identity(self) -> RobotIdentity:
        return RobotIdentity(
            robot_id=self.robot_id,
            name=self.robot_name,
            discovery_prefix=self.discovery_prefix,
            topic_prefix=self.topic_prefix,
            page_url=self.page_url,
            camera=self.camera,
            version=version("atom-home-assistant"),
        )

    @property
    def broker_password(self) -> str | None:
        """Raises `SystemExit` when its file cannot be read."""
        if self.mqtt_password is not None:
            return self.mqtt_password.get_secret_value()
        if self.mqtt_password_file is None:
            return None
        try:
            return self.mqtt_password_file.read_text(encoding="utf-8").strip()
        except OSError as error:
            raise SystemExit(f"HOME_ASSISTANT_MQTT_PASSWORD_FILE: {error.filename}: {error.strerror}") from None
