"""The spoken commands stay what they were, half of them never tuned on, and a score says what happened."""

from itertools import islice

from bench.speech.grammar import COUNT, commands, generated, held_out
from bench.speech.playing import Clip
from bench.speech.scoring import Scorer


def clip(command: str, hot: str, plain: str) -> Clip:
    return Clip(command, "hibari", "clean", plain, hot)


def test_the_committed_commands_are_those_of_the_grammar() -> None:
    assert commands() == list(islice(generated(), COUNT))


def test_about_half_of_them_are_held_out_by_their_words_alone() -> None:
    held = [one for one in commands() if held_out(one)]
    assert 0.4 < len(held) / COUNT < 0.6
    assert held == [one for one in reversed(commands()) if held_out(one)][::-1]


async def test_what_was_understood_asked_and_got_wrong_is_told_apart() -> None:
    scorer = Scorer()
    same = await scorer.score(clip("find the red cup", "find the red cup,", "Find the red cup."))
    assert (same.right, same.asked, same.wrong, same.errors, same.words) == (True, False, False, 0, 4)
    asked = await scorer.score(clip("find the red cup", "find the red cup", "Find the red cap."))
    assert (asked.right, asked.asked, asked.wrong, asked.plain_right) == (True, True, False, False)
    wrong = await scorer.score(clip("find the red cup", "find the red bowl", "Find the red bowl."))
    assert (wrong.right, wrong.asked, wrong.wrong) == (False, False, True)
