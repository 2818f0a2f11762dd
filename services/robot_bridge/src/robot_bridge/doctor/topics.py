"""Topics: are they there, under this name, of this type, in a quality that reaches us, and do they speak? Pure."""

from collections.abc import Iterator

from contracts.robot import SensorState
from robot_bridge.doctor.facts import ROLES, Facts, Need, Publisher, Role, type_of
from robot_bridge.doctor.findings import Check, Finding, problem, warning
from robot_bridge.sensing.endpoints import Difference, in_words
from robot_bridge.settings import Channel

CANDIDATES_MAX = 3


def topic_findings(facts: Facts) -> Iterator[Finding]:
    """In the order of `ROLES`."""
    prefix = shared_namespace(facts)
    if prefix is not None:
        yield problem(
            Check.NAMESPACE,
            prefix,
            f"the robot's topics are in the namespace {prefix}, the bridge looks in {facts.ros.namespace or '/'}",
            f"ROBOT_BRIDGE_ROS__NAMESPACE={prefix}",
        )
    for role in ROLES:
        found = facts.publishers.get(facts.names.get(role.setting, ""), ())
        if found:
            yield from _published(role, found, facts)
        elif prefix is None:
            yield from _unpublished(role, facts)
    others = {each.theirs.topic for each in facts.mismatches} - set(facts.names.values())
    for topic in sorted(others):  # the actions' feedback
        yield from _types(topic, facts)


def shared_namespace(facts: Facts) -> str | None:
    """The namespace in which most of what is missing is published; none where that is not the cause."""
    missing = [role for role in ROLES if not facts.publishers.get(facts.names.get(role.setting, ""), ())]
    found: dict[str, int] = {}
    for role in missing:
        tail = f"/{_channel(role, facts).name.lstrip('/')}"
        for topic in facts.topics:
            if topic.endswith(tail) and topic != tail and topic != facts.names.get(role.setting):
                prefix = topic.removesuffix(tail)
                found[prefix] = found.get(prefix, 0) + 1
    best = max(found, key=lambda prefix: found[prefix], default=None)
    return best if best is not None and found[best] >= 3 else None


def _unpublished(role: Role, facts: Facts) -> Iterator[Finding]:
    topic, wanted = facts.names.get(role.setting, role.setting), type_of(role, facts.ros)
    if role.setting == "cmd_vel_nav":
        return  # told with Nav2
    if role.setting == "hazards":
        yield warning(
            Check.HAZARDS_NOT_REPUBLISHED,
            topic,
            "nobody publishes the base's hazards: bumps, cliffs and lifted wheels are known to the base alone",
            "uncomment hazard_detection in the robot's republisher.yaml and restart its service",
        )
        return
    taken = set(facts.names.values())
    candidates = sorted(name for name, types in facts.topics.items() if wanted in types and name not in taken)
    told = problem if role.need is Need.REQUIRED else warning
    if candidates:
        names = ", ".join(candidates[:CANDIDATES_MAX])
        variable = f"ROBOT_BRIDGE_ROS__{role.setting.upper()}__NAME"
        yield told(
            Check.OTHER_NAME, topic, f"nobody publishes it; of its type there is {names}", f"{variable}={candidates[0]}"
        )
    elif not _asleep(role, facts):
        yield told(Check.NOT_PUBLISHED, topic, f"nobody publishes it, nor another {wanted}", "is its driver running?")


def _published(role: Role, found: tuple[Publisher, ...], facts: Facts) -> Iterator[Finding]:
    topic, channel = facts.names[role.setting], _channel(role, facts)
    told = [*_types(topic, facts), *(finding for each in found for finding in _quality(each, topic, channel))]
    yield from told
    if len(told) < len(found):  # somebody's messages arrive
        yield from _traffic(role, topic, facts)


def _types(topic: str, facts: Facts) -> Iterator[Finding]:
    for each in facts.mismatches:
        if each.theirs.topic != topic:
            continue
        match each.difference:
            case Difference.KIND:
                remedy = "set the bridge's type of it (..._TYPE) or the publisher's (Nav2: enable_stamped_cmd_vel)"
                yield problem(Check.OTHER_TYPE, topic, in_words(each), remedy)
            case Difference.VERSION:
                yield problem(Check.OTHER_DEFINITION, topic, in_words(each), "use ROS 2 Jazzy on both sides")


def _quality(each: Publisher, topic: str, channel: Channel) -> Iterator[Finding]:
    if channel.reliability == "reliable" and not each.reliable:
        yield problem(
            Check.RELIABILITY,
            topic,
            f"{each.node} publishes best effort, the bridge asks for reliable: nothing arrives",
            "set its ..._RELIABILITY to best_effort",
        )
    if channel.durability == "transient_local" and not each.transient_local:
        yield problem(
            Check.DURABILITY,
            topic,
            f"{each.node} publishes volatile, the bridge asks for transient_local: nothing arrives",
            "set its ..._DURABILITY to volatile",
        )


def _traffic(role: Role, topic: str, facts: Facts) -> Iterator[Finding]:
    heard = facts.traffic.get(role.setting)
    status = facts.sensors.get(role.sensor)
    if status is not None and status.state is SensorState.NOT_UNDERSTOOD:
        yield problem(Check.NOT_UNDERSTOOD, topic, f"received, not understood: {status.detail}", "see docs/sensors.md")
    elif status is not None and status.detail:
        yield warning(Check.ODD_MESSAGES, topic, status.detail, "see docs/sensors.md")
    if heard is None:
        return
    if heard.messages == 0:
        if role.need is Need.REQUIRED and not _asleep(role, facts):
            yield problem(Check.SILENT, topic, "it is published, and nothing came", "is the sensor running?")
        return
    if heard.hz and heard.hz < role.hz_min:
        yield warning(
            Check.SLOW, topic, f"{heard.hz:.1f} a second come, {role.hz_min:.0f} are wanted", "check the network"
        )
    if role.bytes_s_max and heard.bytes_s > role.bytes_s_max:
        yield warning(
            Check.TOO_MUCH_DATA,
            topic,
            f"{heard.bytes_s / 1e6:.0f} MB/s: a robot's Wi-Fi loses such pictures whole",
            "a smaller size or rate at the camera driver (docs/turtlebot4.md, step 1)",
        )


def _asleep(role: Role, facts: Facts) -> bool:
    """A docked TurtleBot 4 stops its laser and its camera; that is told once."""
    return bool(facts.docked) and role.setting in {"scan", "rgb", "rgb_info", "depth", "depth_info"}


def _channel(role: Role, facts: Facts) -> Channel:
    channel: Channel = getattr(facts.ros, role.setting)
    return channel
