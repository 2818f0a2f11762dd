"""What the settings of every service begin with: where it listens, and where Redis is."""

from typing import Annotated

from pydantic import Field
from pydantic_settings import BaseSettings, SettingsConfigDict

Port = Annotated[int, Field(ge=1, le=65535, description="TCP port to listen on")]


class ServiceSettings(BaseSettings):
    """Read from the environment, with the service's own prefix; frozen."""

    model_config = SettingsConfigDict(frozen=True)

    host: str = Field(default="127.0.0.1", description="address to listen on; 0.0.0.0 for every one of the machine")
    port: Port
    redis_url: str = Field(default="redis://127.0.0.1:6379/0", description="of the bus")
