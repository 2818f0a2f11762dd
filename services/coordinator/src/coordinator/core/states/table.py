"""Which state does what, by the rules of the mission: chosen here, once."""

from functools import cache

from contracts.mission import MissionKind, MissionState
from coordinator.core.mission import Mission
from coordinator.core.plain.approaching import PlainDepthCheck, StraightApproach, StraightStep
from coordinator.core.plain.centering import proportional_turn
from coordinator.core.plain.searching import PlannedOnce, SlowTurn
from coordinator.core.rules import ApproachRule, CenteringRule, CoverageRule, ScanRule, ValidationRule
from coordinator.core.states.approaching import Approaching
from coordinator.core.states.believing import ByBelief
from coordinator.core.states.centering import Centering, bearing_turn
from coordinator.core.states.depth_check import DepthCheck
from coordinator.core.states.direct import DirectApproach, DirectCentering
from coordinator.core.states.docking import GoingToDock
from coordinator.core.states.driving_1m import Driving1m
from coordinator.core.states.exploring import Exploring
from coordinator.core.states.moving import Moving
from coordinator.core.states.resting import Resting
from coordinator.core.states.scanning import Scanning
from coordinator.core.states.state import State
from coordinator.core.states.travelling import MemoryNav, MovingToScan
from coordinator.core.states.weighing import WeighingDepthCheck

RESTING, DOCKING, MOVING_TO_SCAN = Resting(), GoingToDock(), MovingToScan()
MOVING, EXPLORING = Moving(), Exploring()
TRAVELLING = {CoverageRule.LAWNMOWER: PlannedOnce(), CoverageRule.BELIEF: ByBelief()}


def state_of(mission: Mission) -> State:
    if mission.kind is MissionKind.DOCK and mission.state is MissionState.MEMORY_NAV:
        return DOCKING
    rules, coverage = mission.rules, mission.rules.coverage_rule
    if mission.target is None and coverage is CoverageRule.BELIEF:
        coverage = CoverageRule.VIEWPOINTS  # there is no belief of where nothing is
    table = states(rules.approach_rule, rules.centering_rule, coverage, rules.scan_rule, rules.validation_rule)
    return table[mission.state]


@cache
def states(
    approach: ApproachRule,
    centering: CenteringRule,
    coverage: CoverageRule,
    scan: ScanRule,
    validation: ValidationRule,
) -> dict[MissionState, State]:
    straight, direct = approach is ApproachRule.STRAIGHT, approach is ApproachRule.DIRECT
    judging = WeighingDepthCheck() if validation is ValidationRule.EVIDENCE else DepthCheck()
    turn = bearing_turn if centering is CenteringRule.BEARING else proportional_turn
    return {
        MissionState.IDLE: RESTING,
        MissionState.MEMORY_NAV: MemoryNav(),
        MissionState.SCANNING: SlowTurn() if scan is ScanRule.SLOW_TURN else Scanning(),
        MissionState.MOVING_TO_SCAN: TRAVELLING.get(coverage, MOVING_TO_SCAN),
        MissionState.CENTERING: (DirectCentering if direct else Centering)(turn, finishes_unseen=not straight),
        MissionState.DEPTH_CHECK: PlainDepthCheck() if straight else judging,
        MissionState.APPROACHING: StraightApproach() if straight else DirectApproach() if direct else Approaching(),
        MissionState.DRIVING_1M: StraightStep() if straight else Driving1m(),
        MissionState.MOVING: MOVING,
        MissionState.EXPLORING: EXPLORING,
        MissionState.DONE: RESTING,
        MissionState.EMERGENCY_STOP: RESTING,
    }
