"""Whatever is asked to stop, or dies, the robot stands still, and the mesh heals."""

import logging
import signal

import pytest

from bench.hostility.holding import holdings
from bench.soak import HANDLES_MORE_MAX, Soak, round_of
from contracts.mission import EndCause, Outcome
from demo.stack import SERVICES
from support.mesh_run import MeshRun

REST_WITHIN_S = 0.5
DRAINS_WITHIN_S = 5.0
BASE_RESTS_WITHIN_S = 0.9
"""Without the bridge: the base's own timeout (0.5 s), its ramp from full speed (0.34 s), a slice of the simulation."""


@pytest.fixture(autouse=True)
def begin_at_rest(mesh: MeshRun) -> None:
    mesh.rested()


def seconds_to_rest(mesh: MeshRun, since_s: float) -> float:
    """Simulated seconds from `since_s` until the robot's last motion, as the simulation itself kept it."""
    mesh.until(mesh.still, timeout_s=30.0, what="a robot at rest")
    seconds = float(mesh.truth()["moved_at_s"]) - since_s
    logging.getLogger(__name__).info("at rest after %.2f s", seconds)
    return seconds


def test_the_emergency_stop_stops_and_it_stays_stopped(mesh: MeshRun) -> None:
    mission_id = mesh.driving()
    at_s = mesh.simulated_s()
    stopped = mesh.http.post(mesh.url("robot_bridge", "/emergency-stop"))  # as curl -X POST does: no body
    assert stopped.status_code == 200
    assert seconds_to_rest(mesh, at_s) <= REST_WITHIN_S
    mesh.stays_at_rest_for(3.0)
    mesh.until(
        lambda: mesh.get("coordinator", f"/missions/{mission_id}")["outcome"] == "aborted",
        timeout_s=30.0,
        what="an aborted mission",
    )
    refused = mesh.post("coordinator", "/missions", {"command": "find the red bottle"})
    assert refused.status_code == 409
    mesh.post("robot_bridge", "/emergency-stop/reset").raise_for_status()
    mesh.stays_at_rest_for(2.0)


def test_missions_that_are_stopped_leave_no_handle_open(mesh: MeshRun) -> None:
    """`make bench-soak` does more of it, for hours."""
    soak = Soak()
    stopped_in_mid_drive = 3
    round_of(mesh, soak, stopped_in_mid_drive)
    before = holdings(mesh.stack)
    for _ in range(2):
        round_of(mesh, soak, stopped_in_mid_drive)
    after = holdings(mesh.stack)
    assert soak.ended == {"aborted": 3}
    assert {name: one.pid for name, one in after.items()} == {name: one.pid for name, one in before.items()}
    more = {name: after[name].handles - before[name].handles for name in before}
    assert max(more.values()) <= HANDLES_MORE_MAX, more


def test_killing_the_coordinator_brings_the_robot_to_rest_and_nothing_resumes(mesh: MeshRun) -> None:
    mesh.driving()
    at_s = mesh.kill("coordinator")
    assert seconds_to_rest(mesh, at_s) <= REST_WITHIN_S
    mesh.until(mesh.ready, timeout_s=240.0, what="the mesh ready again after the coordinator died")
    mesh.stays_at_rest_for(2.0)


def test_a_coordinator_that_is_updated_ends_its_mission_as_interrupted_and_nothing_resumes(mesh: MeshRun) -> None:
    """`bench.faults` does it to every service, and to one after the other."""
    mission_id = mesh.driving()
    at_s = mesh.kill("coordinator", signal.SIGTERM)
    assert seconds_to_rest(mesh, at_s) <= DRAINS_WITHIN_S + REST_WITHIN_S
    mesh.until(mesh.ready, timeout_s=240.0, what="the mesh ready again after the coordinator was updated")
    told = mesh.get("coordinator", f"/missions/{mission_id}")
    assert (told["outcome"], told["report"]["ended_by"]) == (Outcome.INTERRUPTED, EndCause.RESTART)
    mesh.stays_at_rest_for(2.0)


def test_killing_the_bridge_brings_the_robot_to_rest_before_anything_else(mesh: MeshRun) -> None:
    mesh.driving()
    at_s = mesh.kill("robot_bridge")
    assert seconds_to_rest(mesh, at_s) <= BASE_RESTS_WITHIN_S
    mesh.until(mesh.ready, timeout_s=240.0, what="the mesh ready again after the bridge died")
    mesh.rested()  # the mission may go on by itself, with requests of its own; it can be cancelled as ever


@pytest.mark.parametrize("name", sorted({*SERVICES, "redis"} - {"coordinator", "robot_bridge"}))
def test_any_other_process_may_die_and_comes_back(mesh: MeshRun, name: str) -> None:
    mesh.kill(name)
    mesh.until(lambda: not mesh.ready(), timeout_s=30.0, what=f"{name} missed")
    mesh.stays_at_rest_for(1.0)
    mesh.until(mesh.ready, timeout_s=240.0, what=f"the mesh ready again after {name} died")
