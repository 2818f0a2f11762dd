"""coordinator, for whoever passes a person's words on."""

import uuid
from typing import Final

from pydantic import TypeAdapter, ValidationError

from contracts.mission import Heard, Mission, StartMission
from mesh.errors import UpstreamError
from mesh.http import ServiceClient

STARTED: Final[TypeAdapter[Mission | Heard]] = TypeAdapter(Mission | Heard)


async def start_mission(
    coordinator: ServiceClient, command: str, *, timeout_s: float, key: str | None = None
) -> Mission | Heard:
    """A mission, or the answer to an order ('stop') or to a wish taken back. With the same `key` it begins but once.

    Raises `UpstreamError` where it asks for nothing known, or is not answered as the contract says; `UnavailableError`.
    """
    answer = await coordinator.call(
        "POST",
        "/missions",
        body=StartMission(command=command),
        timeout_s=timeout_s,
        headers={"Idempotency-Key": key or uuid.uuid4().hex},
    )
    try:
        return STARTED.validate_json(answer.content)
    except ValidationError as error:
        raise UpstreamError("coordinator", answer.status_code, "its answer is not the contract's") from error
