"""What the doctor can find: a type for programs, a sentence and a remedy for people."""

from dataclasses import dataclass
from enum import StrEnum


class Severity(StrEnum):
    PROBLEM = "problem"
    """The robot will not work, or not safely."""
    WARNING = "warning"
    """It works, and not as well as it could."""


class Check(StrEnum):
    """Each is one thing that can be wrong."""

    NOTHING_THERE = "nothing_there"
    DISCOVERY_OFF = "discovery_off"
    OTHER_MIDDLEWARE = "other_middleware"
    NAMESPACE = "namespace"
    OTHER_NAME = "other_name"
    NOT_PUBLISHED = "not_published"
    OTHER_TYPE = "other_type"
    OTHER_DEFINITION = "other_definition"
    RELIABILITY = "reliability"
    DURABILITY = "durability"
    SILENT = "silent"
    NOT_UNDERSTOOD = "not_understood"
    ODD_MESSAGES = "odd_messages"
    SLOW = "slow"
    TOO_MUCH_DATA = "too_much_data"
    CLOCK = "clock"
    SIM_TIME = "sim_time"
    FRAME_UNKNOWN = "frame_unknown"
    TWO_PARENTS = "two_parents"
    BASE_NOT_IN_ODOM = "base_not_in_odom"
    NOT_LOCALISED = "not_localised"
    NO_FREE_SPACE = "no_free_space"
    NAV2_AWAY = "nav2_away"
    NAV2_NOT_ACTIVE = "nav2_not_active"
    SERVER_AWAY = "server_away"
    NAV2_PAST_THE_BRIDGE = "nav2_past_the_bridge"
    NAV2_VELOCITY = "nav2_velocity"
    STRANGER_DRIVES = "stranger_drives"
    TWO_BRIDGES = "two_bridges"
    BASE_DEAF = "base_deaf"
    BASE_OTHER_TYPE = "base_other_type"
    GOAL_TOLERANCE = "goal_tolerance"
    PLAN_TOLERANCE = "plan_tolerance"
    SERVER_TIMEOUT = "server_timeout"
    POWER_SAVER = "power_saver"
    HAZARDS_NOT_REPUBLISHED = "hazards_not_republished"
    WHEELS_STOPPED = "wheels_stopped"
    BRIDGE_NOT_READY = "bridge_not_ready"


@dataclass(frozen=True, slots=True)
class Finding:
    """`about` is the topic, node, frame or variable it is found at."""

    check: Check
    severity: Severity
    about: str
    text: str
    remedy: str = ""


def problem(check: Check, about: str, text: str, remedy: str = "") -> Finding:
    return Finding(check, Severity.PROBLEM, about, text, remedy)


def warning(check: Check, about: str, text: str, remedy: str = "") -> Finding:
    return Finding(check, Severity.WARNING, about, text, remedy)
