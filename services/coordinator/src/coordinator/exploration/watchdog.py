"""The model's watchdog: what the robot does while an answer is owed (requirement C9)."""

from enum import StrEnum

from coordinator.exploration.rules import WatchdogRules


class SilenceTier(StrEnum):
    GO_ON = "go_on"
    """What is under way goes on."""
    STAND = "stand"
    """The robot stops and waits."""
    LOCAL = "local"
    """It explores without the model."""
    HOME = "home"
    """It drives home."""


def tier_of(silent_s: float, rules: WatchdogRules) -> SilenceTier:
    """`silent_s`: since the model owes an answer, or the network to it is gone."""
    if silent_s > rules.home_s:
        return SilenceTier.HOME
    if silent_s > rules.local_s:
        return SilenceTier.LOCAL
    if silent_s > rules.stand_s:
        return SilenceTier.STAND
    return SilenceTier.GO_ON
