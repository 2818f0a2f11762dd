"""`python -m robot_bridge.doctor`: what fits on this robot, what does not, and what to set. Moves nothing.

It looks for the very names, types and qualities of service that robot_bridge is configured with (ROBOT_BRIDGE_*).
Exit status: 0 without a problem (warnings allowed), 1 with one, 2 where ROS cannot be used.
"""

import argparse
import json
import os
import sys
from dataclasses import asdict

import httpx
from pydantic import ValidationError

from contracts.problem import Readiness
from mesh.dds import use_mesh_profile
from mesh.logging import configure_logging
from robot_bridge.doctor.checks import diagnose
from robot_bridge.doctor.findings import Severity
from robot_bridge.doctor.report import report
from robot_bridge.settings import Settings


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=8.0, help="how long to listen (%(default)s)")
    parser.add_argument("--json", action="store_true", help="the findings as JSON, for programs")
    options = parser.parse_args()
    settings = Settings.read()
    configure_logging("doctor", level="ERROR")
    use_mesh_profile()
    if not options.json:
        _print(f"looking at the ROS graph for {options.seconds:.0f} s (domain {os.environ.get('ROS_DOMAIN_ID', '0')})")
    try:
        from robot_bridge.doctor.examination import examine
    except ImportError as error:
        _print(f"ROS 2 cannot be used here: {error}")
        sys.exit(2)
    facts = examine(settings, seconds=options.seconds, environment=os.environ, bridge=_bridge(settings))
    findings = diagnose(facts)
    if options.json:
        _print(json.dumps([asdict(finding) for finding in findings], indent=2))
    else:
        _print("\n".join(report(facts, findings)))
    sys.exit(any(finding.severity is Severity.PROBLEM for finding in findings))


def _bridge(settings: Settings) -> Readiness | None:
    host = "127.0.0.1" if settings.host in {"0.0.0.0", "::"} else settings.host
    try:
        answer = httpx.get(f"http://{host}:{settings.port}/ready", timeout=2.0)
        return Readiness.model_validate_json(answer.content)
    except (httpx.HTTPError, ValidationError):
        return None


def _print(text: str) -> None:
    sys.stdout.write(f"{text}\n")


if __name__ == "__main__":
    main()
