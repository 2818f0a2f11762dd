"""Every number the mission core decides by: requirements A5 to A12, each with its unit in the name."""

import math
from enum import StrEnum

from pydantic import BaseModel, ConfigDict, Field

from contracts.description import RobotDescription


class CoverageRule(StrEnum):
    VIEWPOINTS = "viewpoints"
    LAWNMOWER = "lawnmower"
    FRONTIER = "frontier"
    RANDOM = "random"
    BELIEF = "belief"


class ScanRule(StrEnum):
    STOP_AND_LOOK = "stop_and_look"
    SLOW_TURN = "slow_turn"


class CenteringRule(StrEnum):
    BEARING = "bearing"
    PROPORTIONAL = "proportional"


class ApproachRule(StrEnum):
    LOCALIZED = "localized"
    DIRECT = "direct"
    STRAIGHT = "straight"


class ValidationRule(StrEnum):
    TWO_OF_THREE = "two_of_three"
    EVIDENCE = "evidence"


class Policy(BaseModel):
    """Defaults are the requirements' numbers; where a better rule stands, the plain one stays selectable."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    coverage_rule: CoverageRule = Field(
        default=CoverageRule.BELIEF,
        description="where to look next: computed viewpoints, the lawnmower of requirement A6, or what is worth most a "
        "second by one belief (docs/search.md); to compare with: the "
        "nearest frontier, or viewpoints in random order",
    )
    scan_rule: ScanRule = Field(default=ScanRule.STOP_AND_LOOK, description="look round in steps, or in one slow turn")
    centering_rule: CenteringRule = Field(
        default=CenteringRule.BEARING,
        description="turn by the measured bearing, or by the pixel error of requirement A8",
    )
    approach_rule: ApproachRule = Field(
        default=ApproachRule.DIRECT,
        description="drive to a measured place on the map, at once (direct) or when judged, or straight ahead (A10)",
    )

    validation_rule: ValidationRule = Field(
        default=ValidationRule.EVIDENCE,
        description="two of three votes on one picture (requirement A11), or those and what all looks at it come to",
    )

    # deadlines
    mission_timeout_s: float = Field(default=900.0, gt=0.0, description="of a whole mission")
    pause_timeout_s: float = Field(default=600.0, gt=0.0, description="a mission paused for longer is aborted")
    undock_timeout_s: float = Field(default=95.0, gt=0.0, description="to leave the dock")
    wake_s_max: float = Field(default=60.0, ge=0.0, description="for the first picture after the dock: a power saver")
    goal_timeout_s: float = Field(default=120.0, gt=0.0, description="of one drive by Nav2")
    plan_timeout_s: float = Field(default=20.0, gt=0.0, description="to compute where to look")
    turn_timeout_s: float = Field(default=15.0, gt=0.0, description="of one turn")
    validate_timeout_s: float = Field(default=30.0, gt=0.0, description="for the votes")
    call_margin_s: float = Field(default=3.0, gt=0.0, description="a call is given up this long after its own limit")
    retry_wait_s: float = Field(default=2.0, gt=0.0, description="after a failed call; grows with each one in a row")
    retry_wait_factor: float = Field(default=1.5, ge=1.0, le=4.0, description="by which the wait grows")
    retry_wait_s_max: float = Field(default=10.0, gt=0.0, description="longest wait between two tries")
    failures_max: int = Field(default=6, ge=1, description="calls failing in a row before the mission is aborted")
    lifted_s: float = Field(default=1.0, ge=0.0, description="a wheel in the air for so long pauses the mission")
    robot_silent_s: float = Field(default=15.0, gt=0.0, description="without robot.state the mission is aborted")
    lost_pose_s: float = Field(default=45.0, gt=0.0, description="without a place in map before it gives up")
    dock_timeout_s: float = Field(default=240.0, gt=0.0, description="the way there included")
    dock_tries: int = Field(default=2, ge=1, le=5, description="dockings before it gives up")
    done_reset_s: float = Field(default=2.0, gt=0.0, description="in DONE before the robot is idle again")

    # what a service may not claim
    frame_future_s_max: float = Field(
        default=2.0, gt=0.0, description="a frame stamped later than this is not looked at"
    )
    frame_age_s_max: float = Field(default=5.0, gt=0.0, description="a picture older than this is not looked at")
    depth_m_max: float = Field(default=8.0, gt=0.0, description="a distance beyond this was not measured")
    arrived_m: float = Field(default=1.0, gt=0.0, description="farther than this from its goal it has not arrived")
    yes_votes_min: int = Field(default=2, ge=1, le=3, description="a confirmation with fewer is none (requirement A11)")

    # A5, scanning
    memory_views_max: int = Field(default=12, ge=0, le=200, description="remembered places tried before exploring")
    view_separation_m: float = Field(
        default=0.6, ge=0.0, description="remembered places nearer to each other than this are one"
    )
    scan_angle_rad: float = Field(default=7.3304, gt=0.0, le=12.5, description="420 degrees")
    scan_step_rad: float = Field(default=0.7331, gt=0.0, le=1.6, description="42 degrees; the camera sees about 54")
    scan_speed_rad_s: float = Field(
        default=1.0, gt=0.0, le=4.0, description="of the turns while looking around, or as it can"
    )
    scan_overlap_min: float = Field(default=0.15, ge=0.0, lt=0.9, description="of one look with the next, of the view")
    scan_looks_min: int = Field(default=3, ge=1, le=20, description="slow turn: looks in which a bearing is in view")
    detector_period_s: float = Field(default=0.2, gt=0.0, le=5.0, description="between looks while scanning")
    look_timeout_s: float = Field(default=5.0, gt=0.0, description="for a picture taken after a turn")
    look_settle_s: float = Field(default=0.15, ge=0.0, description="a frame this young after a turn may be blurred")
    blind_looks_max: int = Field(
        default=12,
        ge=1,
        description="looks in a row without a picture before giving up: inference is away up to 40 s for an update",
    )
    moving_confidence_min: float = Field(default=0.45, ge=0.0, le=1.0, description="for stopping a drive at a sighting")
    moving_twice: bool = Field(default=True, description="and in two pictures in a row; else in one (requirement A13)")

    # A6
    look_range_m: float = Field(default=1.8, gt=0.0, description="what lies nearer than this has been looked at")
    scan_points_max: int = Field(default=4000, ge=1, le=20_000, description="places to look from, at most")
    places_missed_max: int = Field(default=12, ge=1, description="in a row not to be reached: navigation has failed")

    # A8
    centering_gain_rad_s_px: float = Field(default=0.003, gt=0.0, description="per pixel of a 320 px wide frame")
    centering_speed_max_rad_s: float = Field(default=0.3, gt=0.0, description="fastest turn while centering")
    centering_speed_min_rad_s: float = Field(default=0.05, ge=0.0, description="slowest turn that moves the robot")
    centering_tolerance_px: float = Field(default=20.0, gt=0.0, description="of a 320 px wide frame")
    centering_detections: int = Field(default=3, ge=1, description="pictures in a row with the target in the middle")
    centering_lost_s: float = Field(
        default=4.0, gt=0.0, description="without the target before it counts as out of sight"
    )
    centering_timeout_s: float = Field(default=15.0, gt=0.0, description="to center one candidate")
    other_colour_looks: int = Field(default=6, ge=1, description="more pictures that name another colour than its own")
    track_rad: float = Field(default=0.35, gt=0.0, description="a box this far from where it was is another thing")
    lease_s: float = Field(default=0.4, gt=0.0, le=2.0, description="how long one velocity request holds")

    # A10
    reach_m: float = Field(default=0.45, gt=0.0, description="nearer than this the target is reached")
    near_m: float = Field(default=1.5, gt=0.0, description="a confirmed target this near is driven up to at once")
    far_m: float = Field(
        default=2.5, gt=0.0, description="farther than this it goes closer before it asks for the votes"
    )
    step_m: float = Field(default=1.0, gt=0.0, le=2.0, description="of one drive closer (DRIVING_1M)")
    approach_speed_m_s: float = Field(default=0.2, gt=0.0, le=2.0, description="of the last drive, or as it can")
    depth_period_s: float = Field(default=0.5, gt=0.0, description="between two measurements")
    drift_px: float = Field(default=50.0, gt=0.0, description="of a 320 px wide frame")
    depth_samples: int = Field(default=3, ge=1, le=9, description="measurements of one distance")
    depth_agree: int = Field(default=3, ge=1, le=9, description="so many have to agree, or more are taken")
    depth_samples_max: int = Field(default=7, ge=1, le=20, description="measurements before it gives up on agreement")
    stand_off_m: float = Field(default=0.40, gt=0.0, description="the final drive aims at this, to end within reach")
    rounds_max: int = Field(default=8, ge=1, description="centerings of one candidate before it is given up")

    # the localized approach
    ring_radii_m: tuple[float, ...] = Field(
        default=(0.62, 0.8, 1.0, 1.3),
        min_length=1,
        max_length=8,
        description="distances from the target of places to drive to",
    )
    step_ring_radii_m: tuple[float, ...] = Field(
        default=(1.25, 1.5), min_length=1, max_length=8, description="the same for a first step towards a far target"
    )
    ring_angles_rad: tuple[float, ...] = Field(
        default=(0.0, 0.35, -0.35, 0.7, -0.7, 1.1, -1.1, 1.6, -1.6),
        min_length=1,
        max_length=24,
        description="directions of those places, from where the robot stands",
    )
    goal_m_min: float = Field(
        default=0.3,
        ge=0.0,
        description="a goal nearer than this may end without a move: turned and driven",
    )
    ring_turn_cost_m_rad: float = Field(default=0.4, ge=0.0, description="path worth one radian round the object")
    ring_skip_m: float = Field(default=0.85, ge=0.0, description="nearer than this the drive is straight")
    face_tolerance_rad: float = Field(default=0.05, gt=0.0, description="a target this near to straight ahead is faced")
    look_again_s: float = Field(default=2.5, gt=0.0, description="for a picture of the target after a drive")
    blocked_alternative_m: float = Field(
        default=0.58, gt=0.0, description="stopped farther off than this: another side"
    )
    alternatives_max: int = Field(default=1, ge=0, le=5, description="other sides to try when the way is blocked")

    judge_tries: int = Field(default=3, ge=1, description="validations of one candidate that may fail")

    # rejection
    rejected_radius_m: float = Field(
        default=0.5, gt=0.0, description="a sighting this near to a rejected one is the same thing"
    )
    rejected_bearing_rad: float = Field(default=0.15, gt=0.0, description="the same where no distance was measured")
    narrow_margin: float = Field(default=0.06, ge=0.0, description="a score this close to its threshold was narrow")
    sure_confidence_min: float = Field(
        default=0.6, ge=0.0, le=1.0, description="a detector this sure of the right colour, outvoted: it may be it"
    )
    closer_looks_max: int = Field(default=1, ge=0, description="looks from nearer after a narrow no")
    unseen_again_max: int = Field(default=2, ge=0, description="a no on a picture without its box is asked again")
    confirm_log_odds: float = Field(default=0.5, ge=0.0, le=20.0, description="all looks together, to confirm")
    doubt_log_odds: float = Field(default=-1.0, ge=-20.0, le=0.0, description="a refused thing above it is in doubt")
    other_sides_max: int = Field(default=2, ge=0, le=8, description="other sides a thing in doubt is looked at from")
    revisits_max: int = Field(default=3, ge=0, le=20, description="things in doubt looked at again in the end")
    rejudge_share: float = Field(
        default=0.6,
        ge=0.0,
        lt=1.0,
        description="what was refused is judged again from within this share of the distance",
    )


class Rules(Policy):
    """The policy for one robot: with its camera, and no faster than it can."""

    camera_hfov_rad: float = Field(default=0.0, ge=0.0, le=math.pi, description="0: not described, it sees nothing")
    camera_forward_m: float = Field(default=0.0, description="camera ahead of the base's centre; behind it: negative")

    @classmethod
    def of(cls, policy: Policy, robot: RobotDescription | None) -> "Rules":
        """Without a description no search may begin: a camera that sees nothing finds nothing."""
        told = policy.model_dump(include=set(Policy.model_fields))
        if robot is None:
            return cls.model_validate(told)
        return cls.model_validate(
            told
            | {
                "approach_speed_m_s": min(policy.approach_speed_m_s, robot.speed_m_s_max),
                "scan_speed_rad_s": min(policy.scan_speed_rad_s, robot.turn_rad_s_max),
                "camera_hfov_rad": robot.camera.hfov_rad,
                "camera_forward_m": robot.camera.position_in_base.x,
            }
        )
