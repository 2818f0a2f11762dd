"""What `GET /metrics` of a service says, by sample."""

import httpx
import metrics_table
from prometheus_client.parser import text_string_to_metric_families

Samples = dict[tuple[str, frozenset[tuple[str, str]]], float]


async def scraped(client: httpx.AsyncClient) -> Samples:
    answer = await client.get("/metrics")
    assert answer.is_success
    return {
        (one.name, frozenset(one.labels.items())): one.value
        for family in text_string_to_metric_families(answer.text)
        for one in family.samples
    }


def sample(samples: Samples, name: str, **labels: str) -> float:
    return samples[name, frozenset(labels.items())]


def untold(samples: Samples, service: str) -> set[str]:
    """What the table promises of a service, and nothing is told of. What an adapter counts is known once it is loaded;
    a metric with labels once something has happened."""
    told = {name for name, _ in samples}
    promised = [one for one in metrics_table.metrics() if one.told_by == service and not one.labels]
    return {one.name for one in promised if not one.in_adapter and not one.samples & told}
