from contracts.mission import MissionState
from coordinator.execution.mission_messages import FAST


def test_it_looks_often_while_it_searches_or_nears_and_seldom_while_it_drives_or_rests() -> None:
    assert set(MissionState) - FAST == {
        MissionState.IDLE,
        MissionState.MEMORY_NAV,
        MissionState.MOVING_TO_SCAN,
        MissionState.DONE,
        MissionState.EMERGENCY_STOP,
    }
