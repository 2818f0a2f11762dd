"""What surrounds a language model: the breaker before it, the checks behind it, the settings that choose it."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from contracts.coco import COCO_LABELS
from contracts.colours import COLOUR_WORDS, Colour
from contracts.vision import ModelState, ParseTaskRequest
from inference.language.breaker import Breaker
from inference.language.language_settings import ReaderKind, is_local
from inference.language.prompts import PresenceAnswer, TaskAnswer, presence_prompt
from inference.language.providers import Providers
from inference.parsing.claims import checked
from inference.parsing.lexicon import lexicon
from inference.reasoning.grounding import invented
from inference.settings import Settings
from mesh.clock import SystemClock
from support.inference_fakes import FakeLanguageModel
from vocabulary.folding import joined, plain_words_of
from vocabulary.spelling import singular_forms


def test_one_caller_tries_what_was_down_and_the_others_wait_for_what_it_learns() -> None:
    breaker = Breaker(retry_after_s=30.0)
    breaker.failed(10.0, "away")
    assert [breaker.allows(at_s) for at_s in (39.9, 40.0, 40.1, 69.9)] == [False, True, False, False]
    breaker.succeeded()
    assert [breaker.allows(70.0), breaker.allows(70.0)] == [True, True]


def test_a_trial_nobody_reports_on_is_given_to_the_next() -> None:
    breaker = Breaker(retry_after_s=30.0)
    breaker.failed(0.0, "away")
    assert [breaker.allows(30.0), breaker.allows(59.0), breaker.allows(60.0)] == [True, False, True]


def test_answers_without_sense_open_it_only_when_they_go_on() -> None:
    breaker = Breaker(retry_after_s=30.0, wrong_answers_max=2)
    breaker.answered_wrong(0.0, "prose")
    assert breaker.allows(0.0)
    breaker.succeeded()
    breaker.answered_wrong(1.0, "prose")
    breaker.answered_wrong(2.0, "prose")
    assert (breaker.allows(3.0), breaker.last_error) == (False, "prose")


def test_a_model_is_named_wrong_at_once_when_it_was_never_right_and_when_it_goes_on_when_it_was() -> None:
    breaker = Breaker(retry_after_s=30.0, wrong_answers_max=2)
    states = [breaker.state]
    for happens in (
        lambda: breaker.answered_wrong(0.0, "prose"),
        breaker.succeeded,
        lambda: breaker.answered_wrong(1.0, "prose"),
        lambda: breaker.answered_wrong(2.0, "prose"),
        lambda: breaker.failed(40.0, "away"),
        lambda: breaker.answered_wrong(80.0, "prose"),
        breaker.succeeded,
    ):
        happens()
        states.append(breaker.state)
    ready, away, wrong = ModelState.READY, ModelState.AWAY, ModelState.ANSWERS_WRONG
    assert states == [ready, wrong, ready, ready, wrong, away, wrong, ready]


async def test_a_model_that_hangs_leaves_the_next_one_its_share_of_the_time() -> None:
    models = [FakeLanguageModel(hangs=True, name="first"), FakeLanguageModel(says={"present": "yes"}, name="second")]
    providers = Providers.of(models, retry_after_s=1e6, clock=SystemClock())
    prompt = presence_prompt(b"", "red bottle")
    assert await providers.ask(prompt, PresenceAnswer, deadline_s=0.2) == (PresenceAnswer(present="yes"), "second")
    assert await providers.ask(prompt, PresenceAnswer, deadline_s=0.2) == (PresenceAnswer(present="yes"), "second")
    assert [one.asked for one in models] == [1, 2]


WORDS = sorted({word for name in lexicon().names for word in name} | {"the", "find", "on", *Colour, "wooden", "drive"})


@given(
    st.sampled_from((*COCO_LABELS, "none", "robot", "cups")),
    st.text(max_size=64),
    st.lists(st.sampled_from(WORDS), max_size=8).map(" ".join),
    st.lists(st.sampled_from(WORDS), min_size=1, max_size=12).map(" ".join),
)
def test_of_a_claim_only_labels_and_said_words_are_left(label: str, place: str, claim: str, command: str) -> None:
    request = ParseTaskRequest(command=command, labels_in_memory=("bed", "couch"))
    answer = TaskAnswer(yolo_class=label, memory_object=place, description=claim)
    kept = checked(answer, request, said=command, by="model")
    assert kept.yolo_class in {*COCO_LABELS, "none"}
    assert kept.memory_object in {None, "bed", "couch"}
    said = {
        form
        for token in joined(plain_words_of(command)).split()
        for form in (token, COLOUR_WORDS.get(token, token), *singular_forms(token))
    }
    names = {w for one in lexicon().names.values() if one.label == label for w in one.words} | set(label.split())
    attributes = lexicon().attributes
    words = kept.description.split()
    assert set(words) <= said | names
    assert {word for word in words if word in attributes} <= said | set(label.split())
    assert len(words) <= 5
    assert (kept.description == "") == (kept.yolo_class == "none")


def test_a_colour_that_was_misspelt_counts_as_said_and_is_told_rightly() -> None:
    request = ParseTaskRequest(command="find the yelow cup by the back door")
    claims = [TaskAnswer(yolo_class="cup", description=said) for said in ("yellow cup", "yelow cup", "black cup")]
    kept = [checked(claim, request, said=request.command, by="model").description for claim in claims]
    assert kept == ["yellow cup", "yellow cup", "cup"]


GIVEN = ("where is the mug?", "A red cup was seen 3 times in the kitchen at 07:30, 0.5 m from the fridge.")


@pytest.mark.parametrize(
    ("answer", "extra"),
    [
        ("I saw the red mug three times in the kitchen.", ()),
        ("At 7:30 the cup was 0.50 metres from the refrigerator.", ()),
        ("I do not know.", ()),
        ("It is in the bedroom.", ("bedroom",)),
        ("I saw it 4 times.", ("4",)),
        ("The blue one is next to the teddy bear.", ("teddy bear", "blue")),
        ("Your keys are in the kitchen.", ("key",)),
    ],
)
def test_what_nobody_told_it_is_noticed(answer: str, extra: tuple[str, ...]) -> None:
    assert invented(answer, GIVEN) == extra


@given(st.text(max_size=300), st.lists(st.text(max_size=100), max_size=3))
def test_a_text_invents_nothing_beyond_itself(text: str, others: list[str]) -> None:
    assert invented(text, [text, *others]) == ()


@pytest.mark.parametrize(
    ("text", "order"),
    [
        ("openai, ollama", (ReaderKind.OPENAI, ReaderKind.OLLAMA, ReaderKind.RULES)),
        ("rules,ollama", (ReaderKind.RULES, ReaderKind.OLLAMA)),
        ("rules,rules", (ReaderKind.RULES,)),
        ("", (ReaderKind.OLLAMA, ReaderKind.OPENAI, ReaderKind.RULES)),
    ],
)
def test_the_order_is_read_from_the_environment(
    monkeypatch: pytest.MonkeyPatch, text: str, order: tuple[ReaderKind, ...]
) -> None:
    monkeypatch.setenv("INFERENCE_LANGUAGE_ORDER", text)
    assert Settings().language_order == order


def test_an_unknown_reader_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("INFERENCE_LANGUAGE_ORDER", "oracle")
    with pytest.raises(ValidationError, match="language_order"):
        Settings()


@pytest.mark.parametrize(
    ("url", "local"),
    [
        ("http://127.0.0.1:11434", True),
        ("http://[::1]:11434", True),
        ("http://192.168.1.20:8080/v1", True),
        ("http://ollama:11434", True),
        ("http://host.docker.internal:11434", True),
        ("http://studio.local:1234/v1", True),
        ("localhost:11434", True),
        ("https://models.example.com/v1", False),
        ("http://8.8.8.8/v1", False),
    ],
)
def test_what_is_on_the_local_network_is_told_by_its_name(url: str, local: bool) -> None:
    assert is_local(url) is local


def test_commands_leave_the_local_network_only_where_that_is_permitted() -> None:
    with pytest.raises(ValidationError, match="not on the local network"):
        Settings(openai_url="https://models.example.com/v1")
    assert Settings(openai_url="https://models.example.com/v1", remote_models_allowed=True).openai_url
