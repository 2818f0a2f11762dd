"""The page's HTTP and WebSocket routes, by topic."""

from fastapi import APIRouter

from ui.routes import live, log_in, memory, pictures, place, rooms, speech, stop, teleop


def routers() -> tuple[APIRouter, ...]:
    return tuple(part.router for part in (stop, log_in, live, teleop, speech, place, pictures, memory, rooms))
