"""Facts in, findings out: everything of a robot that keeps ATOM from working on it, worst first. Pure."""

from collections.abc import Iterator

from robot_bridge.doctor.facts import Facts
from robot_bridge.doctor.findings import Check, Finding, Severity, problem, warning
from robot_bridge.doctor.topics import topic_findings
from robot_bridge.sensing.stamps import apart

RMW = "rmw_fastrtps_cpp"
NAV2_DRIVERS = frozenset(("controller_server", "velocity_smoother", "collision_monitor", "behavior_server"))
GOAL_TOLERANCE_M_MAX = 0.25
PLAN_TOLERANCE_M_MAX = 0.15
SERVER_TIMEOUT_MS_MIN = 100.0
STOP = "base_stop"
"""The bridge's line about the base's own stop: it knows whether it has asked for it."""
PAGE = "docs/turtlebot4.md, step 3"


def diagnose(facts: Facts) -> list[Finding]:
    """Problems before warnings. Where nothing at all is there, only that is told, and what may cause it."""
    found = [*_environment(facts)]
    if not facts.topics:
        found.append(
            problem(
                Check.NOTHING_THERE,
                "ROS",
                "nobody publishes anything in this ROS domain",
                "compare ROS_DOMAIN_ID, ROS_DISCOVERY_SERVER and the network with the robot's",
            )
        )
        return found
    found += [
        *topic_findings(facts), *_clocks(facts), *_frames(facts), *_nav2(facts), *_wheels(facts), *_parameters(facts),
        *_base(facts), *_bridge(facts),
    ]  # fmt: skip
    return sorted(found, key=lambda finding: finding.severity is Severity.WARNING)


def _environment(facts: Facts) -> Iterator[Finding]:
    told = facts.environment
    if told.get("ROS_AUTOMATIC_DISCOVERY_RANGE") == "OFF":
        yield problem(
            Check.DISCOVERY_OFF,
            "ROS_AUTOMATIC_DISCOVERY_RANGE",
            "it is OFF: no other computer or process is found",
            "unset ROS_AUTOMATIC_DISCOVERY_RANGE",
        )
    rmw = told.get("RMW_IMPLEMENTATION", RMW)
    if rmw != RMW:
        yield warning(
            Check.OTHER_MIDDLEWARE,
            "RMW_IMPLEMENTATION",
            f"{rmw}: ATOM is tested with {RMW}, and both ends must use the same",
            f"RMW_IMPLEMENTATION={RMW} on both ends",
        )


def _clocks(facts: Facts) -> Iterator[Finding]:
    for name, behind_s in facts.clocks_behind_s.items():
        yield problem(
            Check.CLOCK, name, f"its clock is {apart(behind_s)} the others", "set the clocks (chrony) on all computers"
        )
    if facts.sim_time_published != facts.ros.use_sim_time:
        text = (
            "a simulator publishes /clock" if facts.sim_time_published else "use_sim_time is set, nobody sends /clock"
        )
        wanted = "true" if facts.sim_time_published else "false"
        yield problem(Check.SIM_TIME, "/clock", text, f"ROBOT_BRIDGE_ROS__USE_SIM_TIME={wanted}")


def _frames(facts: Facts) -> Iterator[Finding]:
    ros = facts.ros
    for frame, parents in sorted(facts.parents.items()):
        if len(parents) > 1:
            names = " and ".join(sorted(parents))
            yield problem(Check.TWO_PARENTS, frame, f"it has two parents: {names}", "let only one node publish it")
    for sensor, frame in sorted(facts.frames.items()):
        if ros.base_frame not in ancestors(frame, facts):
            yield problem(
                Check.FRAME_UNKNOWN,
                frame or f"({sensor}'s frame is unnamed)",
                f"no transform leads from {ros.base_frame} to the frame of {sensor}",
                "start robot_state_publisher, or name the base: ROBOT_BRIDGE_ROS__BASE_FRAME",
            )
    base = ancestors(ros.base_frame, facts)
    if ros.odom_frame not in base:
        yield problem(
            Check.BASE_NOT_IN_ODOM,
            ros.base_frame,
            f"no transform leads from {ros.odom_frame} to {ros.base_frame}: Nav2 cannot drive",
            "the base's driver publishes it; is it running, and are the frames' names right?",
        )
    elif ros.map_frame not in base:
        yield problem(
            Check.NOT_LOCALISED,
            ros.odom_frame,
            f"no transform leads from {ros.map_frame} to {ros.odom_frame}: the robot does not know where it is",
            "start AMCL or SLAM, and give an initial pose (RViz: 2D Pose Estimate)",
        )


def ancestors(frame: str, facts: Facts) -> frozenset[str]:
    """The frame and all above it in tf."""
    seen: set[str] = set()
    waiting = [frame]
    while waiting:
        current = waiting.pop()
        if current and current not in seen:
            seen.add(current)
            waiting += facts.parents.get(current, ())
    return frozenset(seen)


def _nav2(facts: Facts) -> Iterator[Finding]:
    silent = [name for name, state in facts.lifecycle.items() if not state]
    if silent and len(silent) == len(facts.lifecycle):
        yield problem(Check.NAV2_AWAY, "Nav2", f"none of {', '.join(silent)} answers", f"start Nav2 ({PAGE})")
    else:
        for name, state in facts.lifecycle.items():
            if state != "active":
                yield problem(
                    Check.NAV2_NOT_ACTIVE,
                    name,
                    f"it is {state or 'not there'}, not active",
                    "restart Nav2: a dead server is not taken back (exit code -4: no AVX2, take another controller)",
                )
    for name, there in facts.servers.items():
        if not there:
            yield warning(Check.SERVER_AWAY, name, "no server offers it", "is the node running that offers it?")


def _wheels(facts: Facts) -> Iterator[Finding]:
    ros, topic = facts.ros, facts.names["cmd_vel"]
    drivers = [each.node for each in facts.publishers.get(topic, ())]
    own = drivers.count(ros.node_name)
    if own > 1:
        yield problem(Check.TWO_BRIDGES, topic, f"{own} nodes called {ros.node_name} publish it", "end all but one")
    for name in sorted(set(drivers) - {ros.node_name}):
        if name in NAV2_DRIVERS:
            yield problem(
                Check.NAV2_PAST_THE_BRIDGE,
                name,
                f"it publishes {topic} itself: Nav2 drives past the bridge and its stop",
                f"remap Nav2's output to {ros.cmd_vel_nav.name} ({PAGE})",
            )
        elif name not in ros.cmd_vel_known:
            yield warning(
                Check.STRANGER_DRIVES,
                name,
                f"it publishes {topic}, past the bridge and its stop",
                "end it, or remap it",
            )
    if not facts.publishers.get(facts.names["cmd_vel_nav"]) and any(facts.lifecycle.values()):
        yield problem(
            Check.NAV2_VELOCITY,
            facts.names["cmd_vel_nav"],
            "nobody publishes it: goals would be taken, and nothing would move",
            f"remap Nav2's output to it ({PAGE})",
        )
    wanted = f"geometry_msgs/msg/{ros.cmd_vel_type}"
    if not facts.base_listens_for:
        yield problem(Check.BASE_DEAF, topic, "nobody listens to it", "is the base's driver running, under this name?")
    elif wanted not in facts.base_listens_for:
        other = facts.base_listens_for[0].rpartition("/")[2]
        yield problem(
            Check.BASE_OTHER_TYPE,
            topic,
            f"the base listens for {other}, the bridge sends {ros.cmd_vel_type}: nothing moves",
            f"ROBOT_BRIDGE_ROS__CMD_VEL_TYPE={other}",
        )


def _parameters(facts: Facts) -> Iterator[Finding]:
    for name, value in facts.parameters.items():
        if name.endswith(".xy_goal_tolerance") and value > GOAL_TOLERANCE_M_MAX:
            yield warning(Check.GOAL_TOLERANCE, name, f"{value:g} m: goals end so far off", "0.15")
        elif name.startswith("planner_server.") and name.endswith(".tolerance") and value > PLAN_TOLERANCE_M_MAX:
            yield warning(
                Check.PLAN_TOLERANCE, name, f"{value:g} m: plans to occupied goals end elsewhere", f"0.1 ({PAGE})"
            )
        elif name == "bt_navigator.default_server_timeout" and value < SERVER_TIMEOUT_MS_MIN:
            yield warning(
                Check.SERVER_TIMEOUT,
                name,
                f"{value:g} ms: a busy computer aborts goals without a code",
                f"1000 ({PAGE})",
            )


def _base(facts: Facts) -> Iterator[Finding]:
    asleep = [
        name for name in ("scan", "rgb", "depth") if (heard := facts.traffic.get(name)) is None or not heard.messages
    ]
    if facts.docked and asleep:
        yield warning(
            Check.POWER_SAVER,
            ", ".join(asleep),
            "silent, and the robot is docked: its power saver stops the laser and the camera",
            "undock it, or power_saver: false in turtlebot4.yaml",
        )
    asked_for = facts.bridge is not None and all(each.ok for each in facts.bridge.dependencies if each.name == STOP)
    if facts.wheels_enabled is False and not asked_for:
        yield problem(
            Check.WHEELS_STOPPED,
            facts.names.get("wheel_status", "wheel_status"),
            "the base has disabled its wheels: somebody stopped it at the robot",
            "press the robot's power button once",
        )
    if facts.free_area_m2 == 0.0:
        yield problem(
            Check.NO_FREE_SPACE, facts.names.get("map", "map"), "the map shows no free space", "map the home first"
        )


def _bridge(facts: Facts) -> Iterator[Finding]:
    for each in facts.bridge.dependencies if facts.bridge is not None else ():
        if not each.ok:
            yield problem(Check.BRIDGE_NOT_READY, each.name, f"robot_bridge says: {each.detail or 'not ready'}")
