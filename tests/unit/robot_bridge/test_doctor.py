"""The doctor, given the facts of a robot that fits and of forty that do not: each fault is found by name, alone."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from contracts.problem import Dependency, Readiness
from contracts.robot import SensorState, SensorStatus
from robot_bridge.doctor.checks import diagnose
from robot_bridge.doctor.facts import ROLES, Facts, Need, Publisher, Traffic, type_of
from robot_bridge.doctor.findings import Check, Severity
from robot_bridge.doctor.report import report
from robot_bridge.sensing.endpoints import Difference, Endpoint, Mismatch
from robot_bridge.settings import RosSettings

ROS = RosSettings()
STAMPED = "geometry_msgs/msg/TwistStamped"
FRESH = SensorStatus(state=SensorState.FRESH, age_s=0.1)

Change = Callable[[Facts], Facts]


def healthy() -> Facts:
    """A TurtleBot 4 on which everything fits."""
    names = {role.setting: f"/{getattr(ROS, role.setting).name}" for role in ROLES} | {"cmd_vel": "/cmd_vel"}
    publishers = {
        names[role.setting]: (Publisher("driver", type_of(role, ROS), transient_local=True),) for role in ROLES
    }
    return Facts(
        ros=ROS,
        topics={topic: (found[0].type,) for topic, found in publishers.items()},
        names=names,
        publishers=publishers | {"/cmd_vel": (Publisher("robot_bridge", STAMPED),)},
        base_listens_for=(STAMPED,),
        traffic={role.setting: Traffic(60, 10.0, 1e5) for role in ROLES if role.need is Need.REQUIRED},
        sensors={role.sensor: FRESH for role in ROLES if role.sensor},
        parents={
            "odom": frozenset({"map"}),
            "base_link": frozenset({"odom"}),
            "laser": frozenset({"base_link"}),
            "camera": frozenset({"base_link"}),
        },
        frames={"scan": "laser", "rgb": "camera", "depth": "camera"},
        lifecycle=dict.fromkeys(ROS.nav2_lifecycle_nodes, "active"),
        servers={"navigate_to_pose": True, "e_stop": True},
        parameters={"controller_server.goal.xy_goal_tolerance": 0.15, "planner_server.GridBased.tolerance": 0.1},
        wheels_enabled=True,
        docked=False,
        free_area_m2=40.0,
        bridge=Readiness(ready=True, service="robot_bridge", dependencies=(Dependency.of("scan", ok=True),)),
    )


def topic(setting: str, **other: object) -> Change:
    """Its publisher is another."""

    def change(facts: Facts) -> Facts:
        name = facts.names[setting]
        (publisher,) = facts.publishers[name]
        return replace(facts, publishers=dict(facts.publishers) | {name: (replace(publisher, **other),)})  # type: ignore[arg-type]

    return change


def differs(name: str, difference: Difference) -> Change:
    """Who publishes it has another type, or another definition of it."""
    theirs, ours = Endpoint(name, "driver", "theirs/msg/Type"), Endpoint(name, "robot_bridge", "ours/msg/Type")
    return lambda facts: replace(facts, mismatches=(Mismatch(theirs, ours, difference, alone=True),))


def gone(setting: str, **elsewhere: str) -> Change:
    """Nobody publishes it; `elsewhere` names another topic and its type."""

    def change(facts: Facts) -> Facts:
        name = facts.names[setting]
        publishers = {topic: found for topic, found in facts.publishers.items() if topic != name}
        topics = {topic: types for topic, types in facts.topics.items() if topic != name}
        return replace(facts, publishers=publishers, topics=topics | {f"/{k}": (v,) for k, v in elsewhere.items()})

    return change


def drivers(*names: str) -> Change:
    found = tuple(Publisher(name, STAMPED) for name in names)
    return lambda facts: replace(facts, publishers=dict(facts.publishers) | {"/cmd_vel": found})


def traffic(setting: str, heard: Traffic) -> Change:
    return lambda facts: replace(facts, traffic=dict(facts.traffic) | {setting: heard})


def sensor(name: str, state: SensorState, detail: str) -> Change:
    told = SensorStatus(state=state, age_s=None, detail=detail)
    return lambda facts: replace(facts, sensors=dict(facts.sensors) | {name: told})


def parents(frame: str, *above: str) -> Change:
    return lambda facts: replace(facts, parents=dict(facts.parents) | {frame: frozenset(above)})


def given(**changes: object) -> Change:
    return lambda facts: replace(facts, **changes)  # type: ignore[arg-type]


def in_namespace(facts: Facts) -> Facts:
    moved = {f"/robot1{name}": types for name, types in facts.topics.items()}
    return replace(facts, topics=moved, publishers={"/cmd_vel": facts.publishers["/cmd_vel"]}, lifecycle={}, traffic={})


def asleep(facts: Facts) -> Facts:
    silent = dict.fromkeys(("scan", "rgb", "rgb_info", "depth", "depth_info"), Traffic())
    return replace(facts, docked=True, traffic=dict(facts.traffic) | silent)


def unready(name: str) -> Readiness:
    return Readiness(ready=False, service="robot_bridge", dependencies=(Dependency.of(name, ok=False, detail="away"),))


FEEDBACK = "/navigate_to_pose/_action/feedback"
LASER = "sensor_msgs/msg/LaserScan"
FAULTS: list[tuple[Check, str, Change]] = [
    (Check.NOTHING_THERE, "ROS", given(topics={})),
    (
        Check.DISCOVERY_OFF,
        "ROS_AUTOMATIC_DISCOVERY_RANGE",
        given(environment={"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"}),
    ),
    (Check.OTHER_MIDDLEWARE, "RMW_IMPLEMENTATION", given(environment={"RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"})),
    (Check.NAMESPACE, "/robot1", in_namespace),
    (Check.OTHER_NAME, "/scan", gone("scan", scan_raw=LASER)),
    (Check.OTHER_NAME, "/oakd/rgb/preview/image_raw", gone("rgb", camera="sensor_msgs/msg/Image")),
    (Check.NOT_PUBLISHED, "/map", gone("map")),
    (Check.NOT_PUBLISHED, "/battery_state", gone("battery")),
    (Check.NOT_PUBLISHED, "/wheel_status", gone("wheel_status")),
    (Check.HAZARDS_NOT_REPUBLISHED, "/hazard_detection", gone("hazards")),
    (Check.OTHER_TYPE, "/cmd_vel_nav", differs("/cmd_vel_nav", Difference.KIND)),
    (Check.OTHER_TYPE, "/scan", differs("/scan", Difference.KIND)),
    (Check.OTHER_DEFINITION, "/odom", differs("/odom", Difference.VERSION)),
    (Check.OTHER_DEFINITION, FEEDBACK, differs(FEEDBACK, Difference.VERSION)),
    (Check.RELIABILITY, "/tf", topic("tf", reliable=False)),
    (Check.RELIABILITY, "/cmd_vel_nav", topic("cmd_vel_nav", reliable=False)),
    (Check.DURABILITY, "/map", topic("map", transient_local=False)),
    (Check.DURABILITY, "/tf_static", topic("tf_static", transient_local=False)),
    (Check.SILENT, "/scan", traffic("scan", Traffic())),
    (Check.SILENT, "/oakd/stereo/image_raw", traffic("depth", Traffic())),
    (Check.NOT_UNDERSTOOD, "/scan", sensor("scan", SensorState.NOT_UNDERSTOOD, "range_max is 0")),
    (Check.NOT_UNDERSTOOD, "/oakd/rgb/preview/camera_info", sensor("rgb_info", SensorState.NOT_UNDERSTOOD, "a cut")),
    (Check.ODD_MESSAGES, "/battery_state", sensor("battery", SensorState.FRESH, "37 is read as percent")),
    (Check.SLOW, "/scan", traffic("scan", Traffic(10, 1.0, 0.0))),
    (Check.SLOW, "/oakd/rgb/preview/image_raw", traffic("rgb", Traffic(5, 0.5, 1e5))),
    (Check.TOO_MUCH_DATA, "/oakd/stereo/image_raw", traffic("depth", Traffic(200, 30.0, 55e6))),
    (Check.CLOCK, "scan", given(clocks_behind_s={"scan": 3600.0})),
    (Check.SIM_TIME, "/clock", given(sim_time_published=True)),
    (Check.SIM_TIME, "/clock", given(ros=ROS.model_copy(update={"use_sim_time": True}))),
    (Check.FRAME_UNKNOWN, "oak", given(frames={"rgb": "oak"})),
    (Check.FRAME_UNKNOWN, "laser", parents("laser", "tower")),
    (Check.TWO_PARENTS, "laser", parents("laser", "base_link", "tower")),
    (Check.BASE_NOT_IN_ODOM, "base_link", parents("base_link")),
    (Check.NOT_LOCALISED, "odom", parents("odom")),
    (Check.NO_FREE_SPACE, "/map", given(free_area_m2=0.0)),
    (Check.NAV2_AWAY, "Nav2", given(lifecycle=dict.fromkeys(ROS.nav2_lifecycle_nodes, ""))),
    (
        Check.NAV2_NOT_ACTIVE,
        "planner_server",
        given(lifecycle=dict.fromkeys(ROS.nav2_lifecycle_nodes, "active") | {"planner_server": "inactive"}),
    ),
    (Check.SERVER_AWAY, "e_stop", given(servers={"navigate_to_pose": True, "e_stop": False})),
    (Check.NAV2_PAST_THE_BRIDGE, "velocity_smoother", drivers("robot_bridge", "velocity_smoother")),
    (Check.NAV2_VELOCITY, "/cmd_vel_nav", gone("cmd_vel_nav")),
    (Check.STRANGER_DRIVES, "keyboard", drivers("robot_bridge", "keyboard", "docking_server")),
    (Check.TWO_BRIDGES, "/cmd_vel", drivers("robot_bridge", "robot_bridge")),
    (Check.BASE_DEAF, "/cmd_vel", given(base_listens_for=())),
    (Check.BASE_OTHER_TYPE, "/cmd_vel", given(base_listens_for=("geometry_msgs/msg/Twist",))),
    (
        Check.GOAL_TOLERANCE,
        "controller_server.goal.xy_goal_tolerance",
        given(parameters={"controller_server.goal.xy_goal_tolerance": 0.5}),
    ),
    (
        Check.PLAN_TOLERANCE,
        "planner_server.GridBased.tolerance",
        given(parameters={"planner_server.GridBased.tolerance": 0.5}),
    ),
    (
        Check.SERVER_TIMEOUT,
        "bt_navigator.default_server_timeout",
        given(parameters={"bt_navigator.default_server_timeout": 20.0}),
    ),
    (Check.POWER_SAVER, "scan, rgb, depth", asleep),
    (Check.WHEELS_STOPPED, "/wheel_status", given(wheels_enabled=False, bridge=None)),
    (Check.BRIDGE_NOT_READY, "redis", given(bridge=unready("redis"))),
]


def test_nothing_is_found_on_a_robot_that_fits() -> None:
    assert diagnose(healthy()) == []


@pytest.mark.parametrize(("check", "about", "change"), FAULTS, ids=[f"{check}-{about}" for check, about, _ in FAULTS])
def test_each_fault_is_found_by_name_and_alone(check: Check, about: str, change: Change) -> None:
    (finding,) = diagnose(change(healthy()))
    assert (finding.check, finding.about) == (check, about)
    assert finding.text


def test_every_check_has_a_fault_that_it_finds() -> None:
    assert {check for check, _, _ in FAULTS} == set(Check)


def test_wheels_that_the_bridge_itself_has_stopped_are_no_fault() -> None:
    said = Readiness(ready=True, service="robot_bridge", dependencies=(Dependency.of("base_stop", ok=True),))
    assert diagnose(replace(healthy(), wheels_enabled=False, bridge=said)) == []


def test_problems_come_before_warnings_and_the_sum_is_told() -> None:
    facts = gone("hazards")(gone("map")(healthy()))
    findings = diagnose(facts)
    assert [finding.severity for finding in findings] == [Severity.PROBLEM, Severity.WARNING]
    lines = list(report(facts, findings))
    assert lines[-1] == "1 problem(s), 1 warning(s)"
    assert any(line.startswith("  fits     /scan, 10.0 Hz") for line in lines)
    assert not any("fits     /map" in line for line in lines)
