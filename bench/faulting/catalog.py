"""The faults: what is done, what the robot is designed to do then, and a function that does it and looks."""

import asyncio
import os
import signal
import time
from collections.abc import Callable
from dataclasses import dataclass

import httpx

from bench.faulting.campaign import LONG_S, Campaign, Observed
from bench.faulting.flood import Outcome, flood, routes
from bench.faulting.restarts import bridge_updated, coordinator_updated, rolling_update, speech_updated, updated
from contracts.causes import SafetyCause
from contracts.motion import MotionEnd

RGB = ("oakd/rgb/preview/image_raw", "oakd/rgb/preview/camera_info")
DEPTH = ("oakd/stereo/image_raw", "oakd/stereo/camera_info")
FLOOD_HZ, FLOOD_S = 1000.0, 1.0

OLD = (SafetyCause.OLD_SCAN, SafetyCause.NO_SCAN)


@dataclass(frozen=True)
class Fault:
    name: str
    designed: str
    happen: Callable[[Campaign], Observed]
    needs_mission: bool = False
    needs_clock: bool = False


def redis_gone(on: Campaign) -> Observed:
    with on.circling():
        before_m = on.drives(3.0)
        on.supervise("stopProcess", "redis")
        metres = on.drives_on(3.0, before_m=before_m)
        missing = on.missing()
        assert "redis" in missing, missing
        at_s = on.mesh.simulated_s()
        stop_ms = on.stop()
        rest_s = on.rest_after(at_s)
    on.supervise("startProcess", "redis")
    on.mesh.until(lambda: "redis" not in on.missing(), timeout_s=LONG_S, what="Redis connected again")
    assert on.mesh.get("robot_bridge", "/emergency-stop")["latched"]
    on.reset()
    return {
        "driven_before_m": before_m,
        "driven_without_it_m": metres,
        "stop_answer_ms": stop_ms,
        "rest_after_stop_s": rest_s,
    }


def coordinator_gone(on: Campaign) -> Observed:
    on.mesh.driving()
    rest_s = on.rest_after(on.mesh.kill("coordinator"))
    on.mesh.until(on.ready, timeout_s=LONG_S * 2, what="the mesh ready again")
    on.mesh.stays_at_rest_for(2.0)
    return {"rest_after_s": rest_s}


def coordinator_hangs(on: Campaign) -> Observed:
    on.mesh.driving()
    at_s = on.mesh.simulated_s()
    os.kill(on.mesh.pid("coordinator"), signal.SIGSTOP)
    rest_s = on.rest_after(at_s)
    on.mesh.stays_at_rest_for(2.0)
    os.kill(on.mesh.pid("coordinator"), signal.SIGCONT)
    return {"rest_after_s": rest_s}


def bridge_killed_while_latched(on: Campaign) -> Observed:
    with on.circling():
        on.stop()
        epoch = on.mesh.get("robot_bridge", "/emergency-stop")["epoch"]
        pid = on.mesh.pid("robot_bridge")
        on.mesh.kill("robot_bridge")
        on.mesh.until(lambda: on.mesh.pid("robot_bridge") not in {0, pid}, timeout_s=LONG_S, what="a new process")
        answering_s = on.seconds_until(
            lambda: bool(on.mesh.get("robot_bridge", "/health")), "answers", timeout_s=LONG_S
        )
        state = on.mesh.get("robot_bridge", "/emergency-stop")
        assert (state["latched"], state["epoch"]) == (True, epoch), state
        on.mesh.until(on.ready, timeout_s=LONG_S * 2, what="the mesh ready again")
        on.mesh.stays_at_rest_for(2.0)
        assert on.mesh.truth()["e_stop_on"], "the base's own stop"
    newest = on.mesh.get("robot_bridge", "/emergency-stop/history")[0]
    assert newest["action"] == "restored", newest
    on.reset()
    return {"answering_after_s": answering_s, "epoch_kept": epoch}


def bridge_killed_while_driving(on: Campaign) -> Observed:
    with on.circling():
        rest_s = on.rest_after(on.mesh.kill("robot_bridge"))
    on.mesh.until(on.ready, timeout_s=LONG_S * 2, what="the mesh ready again")
    on.mesh.stays_at_rest_for(2.0)
    return {"rest_after_s": rest_s}


def frozen(topic: str, *causes: SafetyCause, turns_on: bool) -> Callable[[Campaign], Observed]:
    def happen(on: Campaign) -> Observed:
        with on.circling() as lease:
            at_s = on.mesh.simulated_s()
            on.wire("freeze", topic)
            no_translation_s = on.seconds_until(on.standing, "no translation")
            on.mesh.until(lambda: lease.held_by(causes), timeout_s=LONG_S, what=f"one of {[*causes]}")
            seen: Observed = {"no_translation_after_s": no_translation_s, "reason": lease.reason}
            if not turns_on:
                seen["no_motion_after_s"] = on.rest_after(at_s)
            on.wire("pass", topic)
            seen["drives_again_after_s"] = on.seconds_until(on.translating, "a driving robot", timeout_s=LONG_S)
        return seen

    return happen


def odometry_frozen_in_a_turn(on: Campaign) -> Observed:
    epoch = on.mesh.get("robot_bridge", "/emergency-stop")["epoch"]
    on.wire("freeze", "odom")
    body = {"angle_rad": 6.0, "speed_rad_s": 1.0, "epoch": epoch}
    reply = on.mesh.http.post(f"{on.url}/rotate", json=body, timeout=LONG_S).json()
    assert reply["end"] == MotionEnd.NO_ODOMETRY, reply
    on.mesh.until(on.mesh.still, timeout_s=LONG_S, what="a robot at rest")
    return {"reply": reply["text"], "turned_rad": round(reply["turned_rad"], 2)}


def camera_gone(on: Campaign) -> Observed:
    with on.circling():
        before_m = on.drives(3.0)
        on.wire("cut", *RGB, *DEPTH)
        on.mesh.until(lambda: {"rgb", "depth"} <= set(on.missing()), timeout_s=LONG_S, what="a bridge that misses it")
        metres = on.drives_on(3.0, before_m=before_m)
        frame = on.mesh.http.get(f"{on.url}/camera/frame", params={"after": time.time() + 1e6, "wait_s": 1})
        box = {"bbox_xyxy": [10, 10, 50, 50], "image_width_px": 250, "image_height_px": 250}
        depth = on.mesh.post("robot_bridge", "/depth", box)
    on.wire("pass", *RGB, *DEPTH)
    on.mesh.until(lambda: not {"rgb", "depth"} & set(on.missing()), timeout_s=LONG_S, what="a camera again")
    return {
        "driven_before_m": before_m,
        "driven_without_it_m": metres,
        "frame": frame.status_code,
        "depth": depth.json().get("reason", ""),
    }


def nav2_gone_in_mid_goal(on: Campaign) -> Observed:
    goal_id = on.goal_far_away()
    at_s = on.mesh.simulated_s()
    on.kill_nav2()
    rest_s = on.rest_after(at_s)
    on.mesh.until(lambda: "nav2" in on.missing(), timeout_s=LONG_S, what="a bridge that misses Nav2")
    ended_s = on.seconds_until(lambda: on.goal_status(goal_id) != "EXECUTING", "the goal's end", timeout_s=LONG_S)
    status = on.goal_status(goal_id)
    on.mesh.stays_at_rest_for(1.0)
    on.start_nav2()
    on.mesh.until(lambda: "nav2" not in on.missing(), timeout_s=LONG_S, what="Nav2 again")
    on.mesh.stays_at_rest_for(1.0)
    again = on.goal_far_away()
    on.mesh.http.delete(f"{on.url}/navigation/goals/{again}")
    on.mesh.until(on.mesh.still, timeout_s=LONG_S, what="a robot at rest")
    return {"rest_after_s": rest_s, "goal": status, "goal_ended_after_s": ended_s}


def nav2_freezes_in_mid_goal(on: Campaign) -> Observed:
    """Its velocity no longer comes, its action still stands."""
    goal_id = on.goal_far_away()
    at_s = on.mesh.simulated_s()
    on.wire("cut", "cmd_vel_nav")
    rest_s = on.rest_after(at_s)
    on.mesh.http.delete(f"{on.url}/navigation/goals/{goal_id}")
    return {"rest_after_s": rest_s}


def clock_stepped(on: Campaign) -> Observed:
    """An hour forwards, then two back, in every process of the mesh, while it drives."""
    if not on.step_clock(0):
        return {"skipped": "libfaketime is not installed"}
    with on.circling():
        before_m = on.drives(4.0)
        seen: Observed = {"driven_before_m": before_m}
        for name, offset_s in (("forwards", 3600), ("backwards", -3600)):
            on.step_clock(offset_s)
            seen[f"driven_{name}_m"] = on.drives_on(4.0, before_m=before_m)
            on.mesh.until(lambda: not on.missing(), timeout_s=LONG_S, what="a ready bridge")
            assert on.mesh.get("robot_bridge", "/state")["pose"] is not None
        state = on.mesh.get("robot_bridge", "/state")
        lease = {"twist": {"linear_x": 0.1}, "source": "stamped", "epoch": state["emergency_stop"]["epoch"]}
        for name, stamp_s in (("future", state["stamp_s"] + 3600), ("past", state["stamp_s"] - 3600)):
            reply = on.mesh.post("robot_bridge", "/velocity", lease | {"stamp_s": stamp_s}).json()
            assert not reply["accepted"], reply
            seen[f"asked_{name}"] = reply["reason"]
        at_s = on.mesh.simulated_s()
        seen["stop_answer_ms"] = on.stop()
        seen["rest_after_stop_s"] = on.rest_after(at_s)
    on.reset()
    return seen


def flooded(on: Campaign) -> Observed:
    """1000 requests a second on one route after the other, and a stop in the middle of each."""
    pid = on.mesh.pid("robot_bridge")
    answers_ms: dict[str, float] = {}
    worst = ("", 0.0)
    sent = 0
    statuses: set[str] = set()
    epoch, gains = (on.mesh.get("robot_bridge", path) for path in ("/emergency-stop", "/motion/gains"))
    for route, body in routes(epoch["epoch"], gains).items():
        outcome, stop_ms = asyncio.run(_flood_and_stop(on, route, body))
        sent += outcome.sent
        statuses |= set(outcome.statuses)
        answers_ms[route] = stop_ms
        worst = max(worst, (route, stop_ms), key=lambda pair: pair[1])
        assert on.mesh.pid("robot_bridge") == pid, f"the bridge died under {route}"
        assert on.mesh.get("robot_bridge", "/health")
        on.mesh.until(on.mesh.still, timeout_s=LONG_S, what="a robot at rest")
        on.reset()
    ordered = sorted(answers_ms.values())
    return {
        "routes": len(answers_ms),
        "sent": sent,
        "statuses": ",".join(sorted(statuses)),
        "stop_answer_median_ms": ordered[len(ordered) // 2],
        "stop_answer_worst": f"{worst[1]} ms under {worst[0]}",
    }


async def _flood_and_stop(on: Campaign, route: str, body: object) -> tuple[Outcome, float]:
    flooding = asyncio.create_task(flood(on.stack.ports.robot_bridge, route, body, rate_hz=FLOOD_HZ, seconds=FLOOD_S))
    async with httpx.AsyncClient(base_url=on.url, trust_env=False, timeout=LONG_S) as http:
        await asyncio.sleep(FLOOD_S / 2)
        began_s = time.monotonic()
        answer = (await http.post("/emergency-stop")).json()
        stop_ms = round((time.monotonic() - began_s) * 1000.0, 1)
    assert answer["state"]["latched"]
    return await flooding, stop_ms


def spoilt(topics: tuple[str, ...], *causes: SafetyCause) -> Callable[[Campaign], Observed]:
    """Senseless values from a sensor that driving needs: no translation, and it says why."""

    def happen(on: Campaign) -> Observed:
        with on.circling() as lease:
            on.wire("spoil", *topics)
            stopped_s = on.seconds_until(on.standing, "no translation")
            on.mesh.until(lambda: lease.held_by(causes), timeout_s=LONG_S, what=f"one of {[*causes]}")
            reason = lease.reason
            on.wire("pass", *topics)
            again_s = on.seconds_until(on.translating, "a driving robot", timeout_s=LONG_S)
        return {"no_translation_after_s": stopped_s, "reason": reason, "drives_again_after_s": again_s}

    return happen


def camera_spoilt(on: Campaign) -> Observed:
    with on.circling():
        before_m, counted = on.drives(3.0), on.metric("robot_bridge_ros_malformed_total")
        on.wire("spoil", *RGB, *DEPTH)
        metres = on.drives_on(3.0, before_m=before_m)
        dropped = on.metric("robot_bridge_ros_malformed_total") - counted
        assert dropped > 0, "nothing was counted"
    return {"driven_before_m": before_m, "driven_m": metres, "dropped_and_counted": int(dropped)}


def nav2_spoilt(on: Campaign) -> Observed:
    refused = 'robot_bridge_velocity_refused_total{reason="not_finite"}'
    goal_id = on.goal_far_away()
    at_s = on.mesh.simulated_s()
    on.wire("spoil", "cmd_vel_nav")
    rest_s = on.rest_after(at_s)
    count = on.metric(refused)
    assert count > 0, "nothing was counted"
    on.mesh.http.delete(f"{on.url}/navigation/goals/{goal_id}")
    return {"rest_after_s": rest_s, "refused_and_counted": int(count)}


FAULTS = (
    Fault("redis_gone", "drives on and stops when told; connects again by itself", redis_gone),
    Fault("coordinator_gone", "its session ends: at rest, nothing resumes", coordinator_gone, needs_mission=True),
    Fault(
        "coordinator_hangs", "its session falls silent: at rest, nothing resumes", coordinator_hangs, needs_mission=True
    ),
    Fault(
        "coordinator_updated",
        "SIGTERM: at rest, the mission is interrupted, nothing resumes",
        coordinator_updated,
        needs_mission=True,
    ),
    Fault(
        "bridge_updated",
        "SIGTERM: at rest while it is away; the mission goes on, or ends with the cause after 15 s without the robot",
        bridge_updated,
        needs_mission=True,
    ),
    Fault(
        "inference_updated", "SIGTERM: the mission waits for it and goes on", updated("inference"), needs_mission=True
    ),
    Fault("memory_updated", "SIGTERM: the mission goes on", updated("memory"), needs_mission=True),
    Fault("ui_updated", "SIGTERM: the mission goes on", updated("ui"), needs_mission=True),
    Fault("speech_updated", "SIGTERM: the mission goes on, nobody misses it", speech_updated, needs_mission=True),
    Fault(
        "rolling_update",
        "SIGTERM to one after the other: the mission ends honestly, nothing resumes",
        rolling_update,
        needs_mission=True,
    ),
    Fault("bridge_killed_latched", "the next process is latched, same epoch", bridge_killed_while_latched),
    Fault("bridge_killed_driving", "the base stops by itself; nothing resumes", bridge_killed_while_driving),
    Fault(
        "scan_frozen",
        "no translation, then no motion",
        frozen("scan", *OLD, turns_on=False),
    ),
    Fault("odometry_frozen", "no translation", frozen("odom", SafetyCause.NO_ODOMETRY, turns_on=True)),
    Fault("odometry_frozen_turn", "a turn is given up", odometry_frozen_in_a_turn),
    Fault("camera_gone", "drives on; 503 or a reason for who asks for pictures", camera_gone),
    Fault("nav2_gone", "at rest, the goal ends, the next one is driven", nav2_gone_in_mid_goal),
    Fault("nav2_frozen", "at rest", nav2_freezes_in_mid_goal),
    Fault(
        "clock_stepped",
        "drives on and stops when told; stamps an hour off are refused",
        clock_stepped,
        needs_clock=True,
    ),
    Fault(
        "scan_nan",
        "no translation: the laser is blind",
        spoilt(("scan",), SafetyCause.BLIND, *OLD),
    ),
    Fault("odometry_nan", "no translation: no odometry", spoilt(("odom",), SafetyCause.NO_ODOMETRY)),
    Fault("camera_senseless", "dropped and counted; drives on", camera_spoilt),
    Fault("nav2_nan", "at rest; refused and counted", nav2_spoilt),
    Fault("flood", "the process lives, every stop is answered", flooded),
)
