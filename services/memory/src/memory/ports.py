"""What the service needs of the world: a place that keeps views."""

from collections.abc import Sequence
from typing import Protocol

from contracts.memory import LabelCount, Observation, View


class Store(Protocol):
    """Keeps views as `memory.views` merges them. Every method raises `mesh.errors.UnavailableError` when it cannot."""

    async def add(self, observations: Sequence[Observation]) -> None:
        """All or nothing, and durable on return."""
        ...

    async def views(self, label: str | None, limit: int) -> list[View]:
        """The label's views, or all: confidence descending, of equals the one first seen first."""
        ...

    async def labels(self, limit: int) -> list[LabelCount]:
        """Most views first, of equals by name."""
        ...

    async def forget(self, label: str) -> int:
        """How many views there were."""
        ...

    async def check(self) -> None:
        """Answers within half a second whether it can be written now."""
        ...

    async def aclose(self) -> None: ...
