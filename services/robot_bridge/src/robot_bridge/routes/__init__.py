"""The bridge's HTTP and WebSocket routes, by topic."""

from fastapi import APIRouter

from robot_bridge.routes import (
    actions,
    arm,
    camera,
    measure,
    motion,
    navigation,
    recordings,
    sessions,
    state,
    stop,
    velocity,
)


def routers() -> tuple[APIRouter, ...]:
    return tuple(
        part.router
        for part in (stop, state, camera, measure, navigation, velocity, motion, sessions, actions, arm, recordings)
    )
