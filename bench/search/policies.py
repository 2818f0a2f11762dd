"""What a policy of the bench is: settings of the coordinator, and no code of its own."""

import json
from collections.abc import Sequence
from typing import Any

from coordinator.settings import Settings

VIEWPOINTS: dict[str, Any] = {
    "coverage_rule": "viewpoints", "approach_rule": "localized", "validation_rule": "two_of_three",
    "approach_speed_m_s": 0.15,
}  # fmt: skip
"""What was the default until the belief was."""
POLICIES: dict[str, dict[str, Any]] = {
    "viewpoints": {},
    "atom": {
        "coverage_rule": "lawnmower", "scan_rule": "slow_turn", "centering_rule": "proportional",
        "approach_rule": "straight", "moving_twice": False,
    },
    "direct": {"approach_rule": "direct"},
    "frontier": {"coverage_rule": "frontier", "memory_views_max": 0},
    "random": {"coverage_rule": "random", "memory_views_max": 0},
    "belief": {
        "coverage_rule": "belief", "approach_rule": "direct", "validation_rule": "evidence", "approach_speed_m_s": 0.2,
        "ring_radii_m": (0.52, 0.62, 0.8, 1.0, 1.3), "blocked_alternative_m": 0.5, "confirm_log_odds": 0.2,
    },
}  # fmt: skip
"""`atom` is A5, A6, A8, A10 and A13 to the letter; `frontier` and `random` know no memory."""


def deciding(settings: Settings, policy: str, changes: Sequence[str]) -> Settings:
    """Raises KeyError for a policy that is none, and for a change that names no setting."""
    told: dict[str, Any] = dict(change.split("=", 1) for change in changes)
    if unknown := told.keys() - Settings.model_fields.keys():
        raise KeyError(f"no settings of the coordinator: {', '.join(sorted(unknown))}")
    told |= {name: json.loads(value) for name, value in told.items() if value.startswith("[")}
    return Settings.model_validate(settings.model_dump() | POLICIES[policy] | told)
