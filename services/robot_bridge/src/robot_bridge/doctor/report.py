"""The doctor's findings as lines for a person. Pure."""

from collections.abc import Iterator, Sequence

from robot_bridge.doctor.facts import ROLES, Facts
from robot_bridge.doctor.findings import Finding, Severity

MARKS = {Severity.PROBLEM: "PROBLEM", Severity.WARNING: "warning"}


def report(facts: Facts, findings: Sequence[Finding]) -> Iterator[str]:
    """A line a topic that fits, then a line or two a finding, then the sum."""
    at_fault = {finding.about for finding in findings}
    for role in ROLES:
        topic = facts.names.get(role.setting, "")
        heard = facts.traffic.get(role.setting)
        if topic not in at_fault and facts.publishers.get(topic):
            rate = f", {heard.hz:.1f} Hz" if heard is not None and heard.hz else ""
            yield f"  fits     {topic}{rate}"
    yield f"  robot_bridge {'answers' if facts.bridge is not None else 'does not run here: looked at without it'}"
    for finding in findings:
        yield f"  {MARKS[finding.severity]:8} {finding.about}: {finding.text}  [{finding.check}]"
        if finding.remedy:
            yield f"           -> {finding.remedy}"
    problems = sum(finding.severity is Severity.PROBLEM for finding in findings)
    yield f"{problems} problem(s), {len(findings) - problems} warning(s)"
