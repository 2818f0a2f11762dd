"""A home that nobody has mapped, explored a little by the whole mesh: two frontiers by Nav2's stand-in."""

import math
from collections.abc import Iterator
from typing import Any

import pytest

from contracts.actions import ActionReply
from contracts.exploration import ExplorationMode
from contracts.mission import Outcome
from support.mesh_run import MeshRun

SETTINGS = {"SIM_MAPPING": "true"}
GOALS = 2


@pytest.fixture(autouse=True)
def at_rest(mesh: MeshRun) -> Iterator[None]:
    mesh.rested()
    yield
    mesh.rested()


def exploration(mesh: MeshRun) -> dict[str, Any]:
    return mesh.get("coordinator", "/state")["exploration"] or {"goals": 0, "explored_m2": None}


@pytest.mark.timeout(300)
def test_the_map_grows_by_two_frontiers_and_a_cancel_brings_it_to_rest(mesh: MeshRun) -> None:
    begun_m2, touched = None, mesh.truth()["collisions"]
    reply = mesh.post("coordinator", "/actions", {"action": "explore"}).raise_for_status()
    mission = ActionReply.model_validate_json(reply.content).mission
    assert mission is not None
    mesh.until(lambda: exploration(mesh)["explored_m2"] is not None, timeout_s=30.0, what="a first map")
    begun_m2 = exploration(mesh)["explored_m2"]
    mesh.until(lambda: exploration(mesh)["goals"] >= GOALS, timeout_s=150.0, what="two frontiers reached")
    told = exploration(mesh)
    assert told["mode"] in {ExplorationMode.FRONTIERS, ExplorationMode.REACTIVE, ExplorationMode.RETURNING}
    assert (told["model"], told["calls"]) == ("", 0)
    assert told["explored_m2"] > begun_m2
    mesh.post("coordinator", f"/missions/{mission.id}/cancel").raise_for_status()
    mesh.until(mesh.still, timeout_s=30.0, what="a robot at rest")
    mesh.stays_at_rest_for(1.0)
    over = mesh.get("coordinator", f"/missions/{mission.id}")
    assert over["outcome"] == Outcome.CANCELED
    assert math.isfinite(over["metres_driven_m"])
    assert over["metres_driven_m"] > 0.5
    assert mesh.truth()["collisions"] == touched
    lines = [one["text"] for one in mesh.get("coordinator", f"/missions/{mission.id}/events")]
    assert "exploring, frontiers: begun" in lines
