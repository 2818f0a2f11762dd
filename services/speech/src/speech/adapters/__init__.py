"""The real parts: Whisper, Silero, hibari, espeak-ng, piper, servers of OpenAI's format and of Wyoming's."""
