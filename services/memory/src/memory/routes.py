"""The HTTP face: thin; every decision is made behind it."""

from typing import Annotated

from fastapi import APIRouter, Depends, Path, Query, Request

from contracts.base import Label
from contracts.memory import (
    DeletedReply,
    LabelCount,
    ObservationBatch,
    ObservationsReply,
    RecallReply,
    RecallRequest,
    View,
)
from memory.remembering import Memory

router = APIRouter()


def get_memory(request: Request) -> Memory:
    return request.state.memory


MemoryDep = Annotated[Memory, Depends(get_memory)]


@router.post("/observations", tags=["writing"])
async def observe(body: ObservationBatch, memory: MemoryDep) -> ObservationsReply:
    """Remembers; durable when answered. Excluded labels are counted as ignored and written nowhere."""
    return await memory.observe(body)


@router.get("/labels", tags=["reading"])
async def labels(memory: MemoryDep, limit: Annotated[int, Query(ge=1, le=1000)] = 500) -> list[LabelCount]:
    """What is remembered at all, most views first."""
    return await memory.labels(limit)


@router.get("/views", tags=["reading"])
async def views(
    memory: MemoryDep,
    label: Annotated[Label | None, Query()] = None,
    limit: Annotated[int, Query(ge=1, le=5000)] = 100,
) -> list[View]:
    """Robot poses from which a thing (or anything) was seen, confidence descending."""
    return await memory.views(label, limit)


@router.post("/recall", tags=["reading"])
async def recall(body: RecallRequest, memory: MemoryDep) -> RecallReply:
    """Where to look for it, best first, each with the reason in words."""
    return await memory.recall(body)


@router.delete("/labels/{label:path}", tags=["writing"])
async def forget(label: Annotated[Label, Path()], memory: MemoryDep) -> DeletedReply:
    """Forgets every view of a label; 404 when there is none."""
    return await memory.forget(label)
