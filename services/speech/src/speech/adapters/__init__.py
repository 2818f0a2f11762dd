"""The real parts: Whisper, Silero, hibari, espeak-ng."""
