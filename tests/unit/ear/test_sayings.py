"""Short sayings are told from talk, clicks and a noisy room, by loudness alone."""

from collections.abc import Iterator

import numpy as np
import pytest

from contracts.speech import RATE_HZ
from ear.ports import CHUNK_BYTES, CHUNK_S
from ear.sayings import LONG_S, Sayings

RNG = np.random.default_rng(0)


def noise(seconds: float, loudness: float) -> bytes:
    return RNG.normal(0.0, loudness, round(seconds * RATE_HZ)).astype("<i2").tobytes()


def taken(sayings: Sayings, sound: bytes) -> list[float]:
    """How long each saying is that was told, in seconds."""
    return [len(one) / RATE_HZ / 2 for one in _taken(sayings, sound)]


def _taken(sayings: Sayings, sound: bytes) -> Iterator[bytes]:
    for at in range(0, len(sound) - CHUNK_BYTES + 1, CHUNK_BYTES):
        saying = sayings.take(sound[at : at + CHUNK_BYTES])
        if saying is not None:
            yield saying


@pytest.mark.parametrize("word_s", [0.24, 0.6, 1.6])
def test_a_short_saying_is_told_with_a_little_silence_around_it(word_s: float) -> None:
    (told_s,) = taken(Sayings(), noise(1.0, 20.0) + noise(word_s, 2000.0) + noise(1.0, 20.0))
    assert word_s + 0.4 <= told_s <= word_s + 0.9


@pytest.mark.parametrize("kind", ["silence", "click", "talk"])
def test_other_sound_is_told_nobody(kind: str) -> None:
    sound = {
        "silence": noise(2.0, 20.0),
        "click": noise(1.0, 20.0) + noise(CHUNK_S, 5000.0) + noise(1.0, 20.0),
        "talk": noise(1.0, 20.0) + noise(LONG_S + 1.0, 2000.0) + noise(1.0, 20.0),
    }[kind]
    assert taken(Sayings(), sound) == []


def test_a_word_behind_a_long_saying_is_told() -> None:
    sayings = Sayings()
    assert taken(sayings, noise(3.2, 2000.0) + noise(1.0, 20.0)) == []
    assert len(taken(sayings, noise(0.48, 2000.0) + noise(1.0, 20.0))) == 1


def test_a_noisy_room_is_got_used_to_and_a_word_over_it_is_told() -> None:
    sayings = Sayings()
    assert taken(sayings, noise(12.0, 400.0)) == []
    assert len(taken(sayings, noise(0.48, 4000.0) + noise(1.6, 400.0))) == 1


def test_it_keeps_no_more_than_a_saying() -> None:
    sayings = Sayings()
    taken(sayings, noise(60.0, 2000.0))
    assert len(b"".join([*sayings._before, *sayings._said])) <= (LONG_S + 0.5) * RATE_HZ * 2
