"""What the coordinator tells Prometheus of its missions."""

from prometheus_client import Counter, Enum, Gauge, Histogram

from contracts.mission import MissionState

MISSIONS = Histogram(
    "coordinator_mission_seconds",
    "from the beginning of a mission to its ending",
    ["kind", "outcome"],
    buckets=(10.0, 30.0, 60.0, 120.0, 180.0, 300.0, 450.0, 600.0, 900.0),
)
STEPS = Histogram(
    "coordinator_step_seconds",
    "to work out an event whole and to set off what follows from it",
    buckets=(0.0003, 0.001, 0.003, 0.01, 0.03, 0.1, 0.3),
)
FAILURES = Counter("coordinator_calls_failed_total", "calls of the mission that failed", ["of"])
DETECTIONS_AGE = Histogram(
    "coordinator_detections_age_seconds",
    "from the capture of a picture to what was seen in it reaching the mission",
    buckets=(0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.5, 1.0, 2.0, 5.0),
)
QUEUE = Gauge("coordinator_queue_missions", "missions that wait for their turn")
STATE = Enum("coordinator_mission_state", "1 for the state it is in", states=[one.value for one in MissionState])
ROBOT_STATE_AGE = Gauge("coordinator_robot_state_age_seconds", "since robot.state came; +Inf = never")
