"""What is watched exists: the table of metrics, the alerts, the dashboard and the scrape targets are of one mind."""

import json
import re
from collections.abc import Iterator
from typing import Any

import metrics_table
import promql_parser
import pytest
import yaml
from settings_page import SERVICES, settings_of

OPS = metrics_table.ROOT / "ops"
ALERTS = yaml.safe_load((OPS / "prometheus/alerts.yml").read_text(encoding="utf-8"))
DASHBOARD = json.loads((OPS / "grafana/dashboards/atom.json").read_text(encoding="utf-8"))
SCRAPED = yaml.safe_load((OPS / "prometheus/prometheus.yml").read_text(encoding="utf-8"))

RULES: list[dict[str, Any]] = [rule for group in ALERTS["groups"] for rule in group["rules"]]
TARGETS: list[dict[str, Any]] = [one for panel in DASHBOARD["panels"] for one in panel.get("targets", [])]
QUERIES = [*(rule["expr"] for rule in RULES), *(target["expr"] for target in TARGETS)]
METRICS = metrics_table.metrics()
OF_PROMETHEUS = {"up": (), "process_resident_memory_bytes": (), "process_cpu_seconds_total": (), "process_open_fds": ()}
LABELS: dict[str, set[str]] = {
    name: {*labels, "service", "job", "le"}
    for known in ({sample: one.labels for one in METRICS for sample in one.samples}, OF_PROMETHEUS)
    for name, labels in known.items()
}


def parts(query: str) -> Iterator[promql_parser.Expr]:
    """Every expression in it. Raises `ValueError` where it cannot be parsed."""
    found: list[promql_parser.Expr] = []
    promql_parser.walk(promql_parser.parse(query), found.append)
    yield from found


def selectors(query: str) -> list[promql_parser.VectorSelector]:
    return [one for one in parts(query) if isinstance(one, promql_parser.VectorSelector)]


def test_the_table_is_as_the_code_is() -> None:
    assert metrics_table.PAGE.read_text(encoding="utf-8") == metrics_table.page(), "run tools/metrics_table.py"


def test_no_name_stands_for_two_metrics() -> None:
    assert len({one.name for one in METRICS}) == len(METRICS)


@pytest.mark.parametrize("metric", METRICS, ids=lambda one: one.name)
def test_a_metric_is_named_as_prometheus_wants_it(metric: metrics_table.Metric) -> None:
    assert re.fullmatch(r"[a-z][a-z0-9_]*[a-z0-9]", metric.name)
    assert metric.name.endswith("_total") == (metric.kind == "counter")
    assert metric.kind != "histogram" or metric.name.endswith("_seconds")
    assert metric.told_by == "every service" or metric.name.startswith(f"{metric.told_by}_")
    assert not re.search(r"_(ms|millis|percent|s)$", metric.name)


@pytest.mark.parametrize("metric", METRICS, ids=lambda one: one.name)
def test_no_label_but_of_what_every_service_says_of_itself_is_one_that_prometheus_sets(
    metric: metrics_table.Metric,
) -> None:
    """Prometheus would rename it `exported_service`, and a query by it would be about who was scraped."""
    assert metric.name.startswith("service_") or not {"service", "job", "instance"} & set(metric.labels)


@pytest.mark.parametrize("query", QUERIES)
def test_a_query_names_metrics_and_labels_that_are_told(query: str) -> None:
    asked = selectors(query)
    assert {one.name for one in asked} <= LABELS.keys()
    assert [m.name for one in asked for m in one.matchers.matchers if m.name not in LABELS[str(one.name)]] == []


@pytest.mark.parametrize("query", QUERIES)
def test_a_query_sums_over_labels_that_are_told(query: str) -> None:
    sums = [one for one in parts(query) if isinstance(one, promql_parser.AggregateExpr) and one.modifier is not None]
    told = set().union(*(LABELS[str(one.name)] for one in selectors(query)))
    assert [label for one in sums for label in one.modifier.labels if label not in told] == []


@pytest.mark.parametrize("rule", RULES, ids=lambda one: one["alert"])
def test_an_alert_says_how_grave_it_is_what_it_is_and_what_to_do(rule: dict[str, Any]) -> None:
    assert rule["labels"]["severity"] in {"warning", "critical"}
    assert set(rule["annotations"]) == {"summary", "do"}
    assert rule.keys() <= {"alert", "expr", "for", "labels", "annotations"}


def test_alerts_have_names_of_their_own() -> None:
    assert len({rule["alert"] for rule in RULES}) == len(RULES)


def test_every_panel_asks_the_one_data_source() -> None:
    shown = [panel for panel in DASHBOARD["panels"] if panel["type"] != "row"]
    assert {panel["datasource"]["uid"] for panel in shown} == {"prometheus"}
    assert len({panel["id"] for panel in DASHBOARD["panels"]}) == len(DASHBOARD["panels"])


def test_what_a_legend_names_is_a_label_of_its_query() -> None:
    named = [
        (label, LABELS[str(one.name)])
        for target in TARGETS
        for label in re.findall(r"{{(\w+)}}", target["legendFormat"])
        for one in selectors(target["expr"])
    ]
    assert [label for label, labels in named if label not in labels] == []


def test_every_service_is_scraped_at_its_own_port() -> None:
    (job,) = SCRAPED["scrape_configs"]
    asked = {one["labels"]["service"]: one["targets"][0] for one in job["static_configs"]}
    assert asked == {name: f"{name}:{settings_of(name).model_fields['port'].default}" for name in SERVICES}
    assert SCRAPED["rule_files"] == ["alerts.yml"]
