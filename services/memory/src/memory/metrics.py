"""What memory tells Prometheus."""

from prometheus_client import Counter, Gauge, Histogram

STORED = Counter("memory_observations_stored_total", "observations written", ["via"])
LOST = Counter("memory_frames_lost_total", "frames dropped because the buffer was full")
WAITING = Gauge("memory_frames_waiting", "frames that wait to be looked at, or to be written", ["to"])
WRITES = Histogram("memory_write_seconds", "to write a batch of frames", buckets=(0.003, 0.01, 0.03, 0.1, 0.3, 1.0))
RECALLS = Histogram("memory_recall_seconds", "to rank where to look", buckets=(0.003, 0.01, 0.03, 0.1, 0.3, 1.0))
