"""DEPTH_CHECK by the plain rule (requirements A9, A10): what lies within reach is found, without a vote."""

from coordinator.core.rules import Rules
from coordinator.core.states.depth_check import DepthCheck


class PlainDepthCheck(DepthCheck):
    takes_unasked = True
    looks_closer = False

    def once_beyond_m(self, rules: Rules) -> float:
        return rules.near_m
