"""What speech tells Prometheus."""

from prometheus_client import Counter, Gauge, Histogram

SECONDS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)

READ = Histogram("speech_transcribe_seconds", "to read one piece of sound, its wait included", buckets=SECONDS)
SPOKEN = Histogram("speech_speak_seconds", "to make one sentence sound, its wait included", buckets=SECONDS)
HEARD = Counter("speech_heard_total", "readings, by what came of them: agree, differ, no_speech", ["outcome"])
REFUSED = Counter("speech_refused_total", "sound that was not taken, and why", ["reason"])
WAITING = Gauge("speech_calls_waiting", "calls that wait or run")
