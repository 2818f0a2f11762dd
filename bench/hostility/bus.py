"""Senseless messages on Redis, from the very users who may publish there."""

import json
import random

import redis.asyncio as redis

from bench.hostility.drawing import Document
from contracts.access import bus_password_of
from contracts.topics import ALL_TOPICS
from demo.stack import Stack

GARBAGE = (b"", b"{", b"null", b"\xff\xfe", b"[" * 50_000, b"{}", b'{"traceparent":"x"}', b" " * 5_000_000, b"1e999")


async def publish(stack: Stack, chance: random.Random) -> str:
    """One message on one topic, and as its kept value where it has one."""
    assert stack.keys is not None
    topic = chance.choice(ALL_TOPICS)
    key = (stack.keys / f"{topic.publisher}.key").read_text().strip()
    client = redis.Redis(
        port=stack.ports.redis, username=topic.publisher, password=bus_password_of(key), socket_timeout=10.0
    )
    schema = topic.message.model_json_schema()
    drawn = json.dumps(Document(schema, chance).value(schema)).encode()
    data = chance.choice((drawn, drawn, drawn, *GARBAGE))
    try:
        if topic.kept:
            await client.set(topic.kept_key, data)
        await client.publish(topic.name, data)
    finally:
        await client.aclose()
    return "published"
