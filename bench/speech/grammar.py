"""What people say to the robot, generated once from a grammar: python -m bench.speech.grammar writes commands.txt.

The half that nobody tunes on is told by a digest of the words, so that it stays the same when the grammar grows.
"""

import hashlib
import random
from collections.abc import Iterator
from pathlib import Path

TABLE = Path(__file__).with_name("commands.txt")
COUNT = 300
SEED = 16
COLOURS = ("red", "blue", "green", "yellow", "white", "black", "orange", "pink", "purple", "brown", "grey")
LIKE = (*COLOURS, *COLOURS, "small", "big", "wooden", "old", "little", "light blue")
THINGS = (
    "bottle", "cup", "mug", "wine glass", "glass", "bowl", "spoon", "fork", "knife", "banana", "apple", "orange",
    "sandwich", "cake", "book", "clock", "vase", "scissors", "teddy bear", "remote", "remote control", "laptop",
    "mouse", "keyboard", "phone", "cell phone", "backpack", "rucksack", "handbag", "bag", "suitcase", "umbrella", "tie",
    "chair", "couch", "sofa", "potted plant", "plant", "ball", "football", "toothbrush", "hair dryer", "water bottle",
    "coffee mug", "teacup", "tablet", "kite", "frisbee", "skateboard", "tennis racket", "toaster", "carrot", "donut",
)  # fmt: skip
UNSEEN = ("keys", "glasses", "wallet", "medicine", "slippers", "hat", "charger", "headphones")
"""Known names that no detector class stands for."""
PAIRS = ("keys", "glasses", "slippers", "headphones", "scissors")
SPOTS = ("table", "couch", "bed", "fridge", "sink", "television", "chair", "oven", "potted plant")
ROOMS = ("kitchen", "living room", "bedroom", "bathroom", "office", "dining room")
MANY = ("bottles", "cups", "chairs", "books", "apples", "bowls", "clocks", "plants", "spoons")
SENTENCES: tuple[tuple[int, tuple[str, ...]], ...] = (
    (46, (
        "find the {thing}", "find the {like} {thing}", "find my {thing}", "find my {like} {thing}",
        "please find the {like} {thing}", "can you find my {thing}", "could you look for the {like} {thing}",
        "look for the {thing}", "search for my {like} {thing}", "where is my {thing}", "where is the {like} {thing}",
        "where did I leave my {thing}", "I can't find my {like} {thing}", "I need the {thing}",
        "have you seen my {like} {thing}", "find the {thing} near the {spot}", "find the {like} {thing} on the {spot}",
        "is there a {thing} in the {room}", "find the {thing} and then the {like} {other}",
        "find the {thing} and the {other}", "I'm looking for my {like} {thing}", "locate the {thing}",
        "find the {like} {thing}, not the {colour} one", "find something to {need}", "show me the {like} {thing}",
        "hey robot, find the {like} {thing}", "find my {unseen}", "where are my {pairs}",
    )),
    (22, (
        "bring me the {thing}", "bring me a {like} {thing}", "bring me the {like} {thing}", "fetch the {thing}",
        "get me the {like} {thing}", "could you bring me my {thing}", "please bring me something to {need}",
        "bring the {thing} from the {room}", "I'm hungry, bring me an apple", "give me the {like} {thing}",
        "grab my {thing}", "can you get me the {thing} from the {spot}", "fetch me a {thing} please",
        "bring me my {unseen}",
    )),
    (4, ("pour the {drink}", "pour me some water", "please pour the {like} {drink}", "pour the medicine",
         "pour the {drink} into the cup")),
    (8, (
        "what is in the {room}", "what have you seen in the {room}", "how full is the battery", "what are you doing",
        "what changed since yesterday", "what do you remember", "where did you last see my {thing}",
        "when did you last see the {like} {thing}", "what did you do today", "is there anything to {need}",
    )),
    (4, ("how many {many} are there", "how many {many} have you seen", "how many {many} are in the {room}",
         "count the {many}")),
    (6, ("go to the {room}", "go to the {spot}", "drive to the {thing}", "come here", "go over to the {like} {thing}",
         "drive to the {room} please")),
    (4, ("go to the dock", "go home", "go back to the dock", "return to your charger", "please go to the dock",
         "drive back to the dock", "go charge")),
    (6, ("stop", "stop moving", "halt", "cancel that", "never mind", "wait", "go on", "emergency stop",
         "that's enough", "stop looking for the {thing}", "never mind the {thing}", "forget it", "please stop now",
         "wait a second", "don't bring me the {thing}", "continue")),
)  # fmt: skip
"""(weight, sentences)"""


def held_out(command: str) -> bool:
    return hashlib.sha256(command.encode()).digest()[0] % 2 == 1


def commands() -> list[str]:
    """As committed, in an order in which each beginning is a fair sample."""
    return TABLE.read_text(encoding="utf-8").splitlines()


def generated(seed: int = SEED) -> Iterator[str]:
    """Without end; each once."""
    draw, told = random.Random(seed), set[str]()
    weights = [weight for weight, _ in SENTENCES]
    while True:
        (_, sentences), *_ = draw.choices(SENTENCES, weights)
        thing, other = draw.sample(THINGS, 2)
        said = draw.choice(sentences).format(
            thing=thing, other=other, like=draw.choice(LIKE), colour=draw.choice(COLOURS), spot=draw.choice(SPOTS),
            room=draw.choice(ROOMS), unseen=draw.choice(UNSEEN), pairs=draw.choice(PAIRS), many=draw.choice(MANY),
            need=draw.choice(("drink", "eat", "read", "sit on")), drink=draw.choice(("bottle", "water bottle", "cup")),
        )  # fmt: skip
        said = _with_articles(said)
        if said not in told:
            told.add(said)
            yield said


def _with_articles(said: str) -> str:
    words = said.split()
    vowels = ("a", "e", "i", "o", "u")
    told = [
        "an" if word == "a" and at + 1 < len(words) and words[at + 1].startswith(vowels) else word
        for at, word in enumerate(words)
    ]
    return " ".join(told)


if __name__ == "__main__":
    said = generated()
    TABLE.write_text("".join(f"{next(said)}\n" for _ in range(COUNT)), encoding="utf-8")
