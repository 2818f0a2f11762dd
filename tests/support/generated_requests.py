"""How generated requests are drawn, and which checks of schemathesis say nothing of an app of ours without keys."""

from hypothesis import HealthCheck, Phase, settings
from schemathesis.specs.openapi.checks import (
    ignored_auth,
    missing_required_header,
    negative_data_rejection,
    positive_data_acceptance,
)

DRAWN = settings(
    deadline=None,
    derandomize=True,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow],
)
"""The same requests in every run; how many is the test's own affair: `settings(DRAWN, max_examples=...)`."""

NOT_PROMISED = [
    # No route is closed without keys: tests/contract/access asks each with keys.
    ignored_auth,
    missing_required_header,
    # Pydantic takes "1" for 1 in a body; that is no harm, but the check calls it one.
    negative_data_rejection,
    # Well-formed, and yet it may make no sense here: 422.
    positive_data_acceptance,
]
