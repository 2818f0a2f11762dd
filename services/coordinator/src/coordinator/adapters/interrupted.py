"""What becomes of a mission whose coordinator ended: reported as interrupted, never taken up again by itself."""

from contracts.mission import EndCause, EventFacts, EventKind, Mission, MissionEvent, MissionState, Outcome, Report


def interrupted(mission: Mission, now_s: float) -> Mission:
    doing = "it waited in the queue" if mission.queue_position is not None else f"it was {mission.state.value}"
    text = f"interrupted: the coordinator stopped while {doing}; it does not resume by itself"
    return mission.model_copy(
        update={
            "state": MissionState.IDLE,
            "paused": False,
            "queue_position": None,
            "outcome": Outcome.INTERRUPTED,
            "reason": text,
            "ended_s": max(now_s, mission.started_s),
            "report": Report(text=text, ended_by=EndCause.RESTART, cause=f"the coordinator stopped while {doing}"),
        }
    )


def line_of(mission: Mission, event_id: int, now_s: float) -> MissionEvent:
    return MissionEvent(
        id=event_id,
        mission_id=mission.id,
        stamp_s=max(0.0, now_s),
        state=MissionState.IDLE,
        kind=EventKind.END,
        text=mission.reason,
        data=EventFacts(outcome=Outcome.INTERRUPTED),
    )
