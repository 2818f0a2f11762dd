"""What a policy of the bench is: settings of the coordinator, and no code of its own."""

import json
from collections.abc import Sequence
from typing import Any

from coordinator.settings import Settings

VIEWPOINTS: dict[str, Any] = {
    "coverage_rule": "viewpoints", "approach_rule": "localized", "validation_rule": "two_of_three",
    "approach_speed_m_s": 0.15,
}  # fmt: skip
"""Each step on its own: drive to a viewpoint, stand and look round, vote on one picture, drive up."""
POLICIES: dict[str, dict[str, Any]] = {
    "belief": {},
    "viewpoints": VIEWPOINTS,
    "direct": VIEWPOINTS | {"approach_rule": "direct"},
    "atom": VIEWPOINTS | {
        "coverage_rule": "lawnmower", "scan_rule": "slow_turn", "centering_rule": "proportional",
        "approach_rule": "straight", "moving_twice": False,
    },
    "frontier": VIEWPOINTS | {"coverage_rule": "frontier", "memory_views_max": 0},
    "random": VIEWPOINTS | {"coverage_rule": "random", "memory_views_max": 0},
}  # fmt: skip
"""`belief` is the robot as it is delivered; `atom` is A5, A6, A8, A10 and A13 to the letter. `frontier` and `random`
know no memory.
"""


def deciding(settings: Settings, policy: str, changes: Sequence[str]) -> Settings:
    """Raises KeyError for a policy that is none, and for a change that names no setting."""
    told: dict[str, Any] = dict(change.split("=", 1) for change in changes)
    if unknown := told.keys() - Settings.model_fields.keys():
        raise KeyError(f"no settings of the coordinator: {', '.join(sorted(unknown))}")
    told |= {name: json.loads(value) for name, value in told.items() if value.startswith("[")}
    return Settings.model_validate(settings.model_dump() | POLICIES[policy] | told)
