"""What is said and heard in a home that is no order to stop: generated sayings, a story, household noise."""

import random
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from bench.speech.grammar import generated
from bench.speech.voices import RATE, Sound
from vocabulary.orders import stop_in

SEED = 1616
PEOPLE = ("Anna", "Tom", "grandma", "Mister Lee", "Sarah", "the neighbour", "my sister", "Paul")
THINGS = ("the laundry", "the dishes", "dinner", "the garden", "that letter", "the car", "the bill", "the shopping")
DAYS = ("on Monday", "tomorrow", "next week", "in the evening", "after lunch", "this afternoon", "at noon", "on Sunday")
DIALOGUE = (
    "Did {person} call about {thing}?", "I told {person} we would look after {thing} {day}.",
    "What do you want for dinner {day}?", "It is quite hot in here, can you open the window?",
    "{person} is coming over {day} and we have nothing to eat.", "Have you done {thing} yet?",
    "The weather should be better {day}.", "I think {person} took the train at half past {number}.",
    "Put it on the top shelf, next to the {number} glasses.", "Could you help me with {thing}, please?",
    "That film was too long, I nearly fell asleep.", "Let's start with {thing} and talk about the rest {day}.",
    "My back hurts, I should have asked {person} to carry it.", "How much did you pay for {thing}?",
    "No, not that one, the other one on the left.", "I will be at the shop until {number}.",
    "{person} said the step by the door is broken.", "We need {number} more chairs {day}.",
    "Turn the music up a bit, I like this song.", "Who left the light on in the hall?",
    "Oh, look at that, it is snowing.", "I have lost my place in the book again.",
    "Yes, of course, I would love to come {day}.", "Is there any soup left, or did {person} eat it all?",
)  # fmt: skip
NUMBERS = (
    "{a}, {b}, {c}, {d}, {e}.", "The number is {a} {b} {c}, {d} {e} {b}.", "It costs {a} euros and {b}{c} cents.",
    "{a} plus {b} is not {c}.", "Room {a}{b}{c} on floor {d}.", "At {a} {b}0 the bus leaves from platform {c}.",
    "Twenty {a}, thirty {b}, forty {c}, fifty {d}.", "Chapter {a}, page {b}{c}{d}.",
)  # fmt: skip
STORY = """The lamp in the lighthouse had burned for ninety years before anybody asked who owned the stairs. There
were two hundred and twelve of them. Old Marten counted them every night on his way up, and every morning on his way
down, and the two numbers were never the same. His daughter thought it was his knees. The postman thought it was the
wind. Marten himself believed that the tower was still growing. One autumn a small robot was sent over from the
mainland in a wooden box with straw in it. It had four wheels, a camera, and a label that said it could find things.
Marten set it on the floor of the kitchen and told it to find the missing step. The robot drove once around the table,
looked at the cat, looked at the stove, and then rolled to the bottom of the stairs and waited. It cannot climb, said
his daughter. It does not have to, said Marten. It only has to look. For three days it sat there and looked. It
watched the boots going up and the boots coming down. It watched the cat, who used every second step, and the smoke,
which used none. On the fourth day it turned around, drove to the pantry, and put its light on a crack between two
boards. Under the boards there was a short flight of steps, dusty and dry, that nobody had walked on for a generation.
They led to a room with a chair, a shelf of books and a window that looked out just above the waves. Marten sat down
in the chair and laughed until the cat came to see what had happened. He had been counting the steps of a tower that
began one floor further down than he thought. In winter he moved his bed to the room below, because it was warmer, and
read the books from left to right. The robot kept him company. In the evening it found his glasses, his pipe, and once
a letter that had slipped behind the shelf before he was born. It was from the man who had built the place. He wrote
that a house should always keep one room for itself, and that whoever found it might stay.
"""
NEAR = (
    "The bus stop is across the road.", "We never stop for lunch before two.", "It would not stop raining.",
    "They had to stop twice on the way to the coast.", "Pop music, hip hop, and a lot of rock.",
    "He put the top back on the pot.", "Step by step we got to the shop.", "Stuff the turkey and chop the onions.",
    "The clock has stopped again.", "Full stop, new line.", "I wish you would start without me.",
    "Salt, malt and hops.", "Why did the car stop?", "Scott bought a spotted top.", "Hold the door for me, please.",
    "She told me to halt the order at the bank.", "Star charts and storm lamps.", "There is a stop sign at the corner.",
)  # fmt: skip
"""Words that sound like an order to stop, or are one in another meaning: counted apart."""


@dataclass(frozen=True, slots=True)
class Kind:
    """`sayings` gives them without end."""

    name: str
    sayings: Callable[[random.Random], Iterator[str]]
    minutes: float
    """Of each voice."""


def _filled(templates: tuple[str, ...]) -> Callable[[random.Random], Iterator[str]]:
    def said(draw: random.Random) -> Iterator[str]:
        while True:
            digits = {letter: draw.randint(1, 9) for letter in "abcde"}
            yield draw.choice(templates).format(
                **digits, person=draw.choice(PEOPLE), thing=draw.choice(THINGS), day=draw.choice(DAYS),
                number=draw.randint(2, 12),
            )  # fmt: skip

    return said


def _commands(draw: random.Random) -> Iterator[str]:
    return (said for said in generated(draw.randrange(2**31)) if not stop_in(said))


def _story(draw: random.Random) -> Iterator[str]:
    sentences = [f"{one.strip()}." for one in STORY.replace("\n", " ").split(".") if one.strip()]
    while True:
        yield from sentences


KINDS = (
    Kind("commands", _commands, 4.0),
    Kind("dialogue", _filled(DIALOGUE), 6.0),
    Kind("numbers", _filled(NUMBERS), 2.5),
    Kind("story", _story, 3.0),
    Kind("near", _filled(NEAR), 1.5),
)


def noises() -> Mapping[str, Callable[[np.random.Generator, int], Sound]]:
    """Without speech; so many samples of 16 kHz."""
    return {"music": _music, "clicks": _clicks, "vacuum": _vacuum, "alarm": _alarm}


def babble(voices: list[Sound], length: int, draw: np.random.Generator) -> Sound:
    """Several people at once, each from somewhere in what they say; as loud as one."""
    mixed = np.zeros(length)
    for one in voices:
        start = int(draw.integers(0, max(1, len(one) - 1)))
        mixed += np.resize(np.roll(one, -start), length)
    return _to(mixed, 0.3)


def _music(draw: np.random.Generator, length: int) -> Sound:
    """Three instruments of six overtones, a beat of noise."""
    time_s = np.arange(length) / RATE
    mixed = np.zeros(length)
    for octave, note_s in ((1.0, 0.5), (2.0, 0.25), (0.5, 1.0)):
        notes = draw.choice([261.6, 293.7, 329.6, 392.0, 440.0], size=int(length / RATE / note_s) + 1) * octave
        pitch = np.repeat(notes, int(note_s * RATE))[:length]
        pitch = np.pad(pitch, (0, length - len(pitch)), mode="edge")
        phase = 2 * np.pi * np.cumsum(pitch) / RATE
        fall = np.exp(-3.0 * (time_s % note_s) / note_s)
        mixed += fall * sum(np.sin(k * phase) / k for k in range(1, 7))
    beat = (time_s % 0.5 < 0.04) * draw.standard_normal(length)
    return _to(mixed + beat, 0.4)


def _clicks(draw: np.random.Generator, length: int) -> Sound:
    """Doors, keys, dishes: short bursts that ring."""
    mixed = np.zeros(length)
    for start in draw.integers(0, max(1, length - RATE // 2), size=length // RATE):
        rings = int(draw.uniform(0.005, 0.25) * RATE)
        ring = np.exp(-6.0 * np.arange(rings) / rings) * draw.standard_normal(rings)
        ring *= 1.0 + np.sin(2 * np.pi * draw.uniform(200, 4000) * np.arange(rings) / RATE)
        mixed[start : start + rings] += draw.uniform(0.2, 1.0) * ring
    return _to(mixed, 0.8)


def _vacuum(draw: np.random.Generator, length: int) -> Sound:
    """A motor that hums and roars and is moved about."""
    time_s = np.arange(length) / RATE
    hum = sum(np.sin(2 * np.pi * 110 * k * time_s) / k for k in range(1, 12))
    roar = np.convolve(draw.standard_normal(length), np.ones(8) / 8, mode="same")
    return _to((hum * 0.3 + roar) * (1.0 + 0.3 * np.sin(2 * np.pi * 0.4 * time_s)), 0.4)


def _alarm(draw: np.random.Generator, length: int) -> Sound:
    """Microwave, phone, smoke detector: beeps."""
    time_s = np.arange(length) / RATE
    pitch = np.where((time_s // 7) % 2 == 0, 2000.0, 950.0)
    return _to(np.sin(2 * np.pi * np.cumsum(pitch) / RATE) * (time_s % 0.6 < 0.3), 0.4)


def _to(sound: np.ndarray, loudest: float) -> Sound:
    return (sound * (loudest / max(1e-9, float(np.abs(sound).max())))).astype(np.float32)
