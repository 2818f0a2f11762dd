"""The ROS 2 interfaces that ATOM needs beyond the common ones: fields in wire order, and constants, by section."""

HEADER = "std_msgs/Header header"

NAV2 = {
    "nav2_msgs/action/NavigateToPose": (
        ("geometry_msgs/PoseStamped pose", "string behavior_tree"),
        ("uint16 NONE=0", "uint16 error_code", "string error_msg"),
        (
            "geometry_msgs/PoseStamped current_pose",
            "builtin_interfaces/Duration navigation_time",
            "builtin_interfaces/Duration estimated_time_remaining",
            "int16 number_of_recoveries",
            "float32 distance_remaining",
        ),
    ),
    "nav2_msgs/action/ComputePathToPose": (
        ("geometry_msgs/PoseStamped goal", "geometry_msgs/PoseStamped start", "string planner_id", "bool use_start"),
        (
            "uint16 NONE=0",
            "uint16 UNKNOWN=200",
            "uint16 INVALID_PLANNER=201",
            "uint16 TF_ERROR=202",
            "uint16 START_OUTSIDE_MAP=203",
            "uint16 GOAL_OUTSIDE_MAP=204",
            "uint16 START_OCCUPIED=205",
            "uint16 GOAL_OCCUPIED=206",
            "uint16 TIMEOUT=207",
            "uint16 NO_VALID_PATH=208",
            "nav_msgs/Path path",
            "builtin_interfaces/Duration planning_time",
            "uint16 error_code",
            "string error_msg",
        ),
        (),
    ),
    "nav2_msgs/srv/ClearEntireCostmap": (("std_msgs/Empty request",), ("std_msgs/Empty response",)),
}

CREATE3 = {
    "irobot_create_msgs/msg/AudioNote": (("uint16 frequency", "builtin_interfaces/Duration max_runtime"),),
    "irobot_create_msgs/msg/AudioNoteVector": ((HEADER, "irobot_create_msgs/AudioNote[] notes", "bool append"),),
    "irobot_create_msgs/msg/LedColor": (("uint8 red", "uint8 green", "uint8 blue"),),
    "irobot_create_msgs/msg/LightringLeds": ((HEADER, "irobot_create_msgs/LedColor[6] leds", "bool override_system"),),
    "irobot_create_msgs/msg/DockStatus": ((HEADER, "bool dock_visible", "bool is_docked"),),
    "irobot_create_msgs/msg/HazardDetection": (
        (
            "uint8 BACKUP_LIMIT=0",
            "uint8 BUMP=1",
            "uint8 CLIFF=2",
            "uint8 STALL=3",
            "uint8 WHEEL_DROP=4",
            "uint8 OBJECT_PROXIMITY=5",
            HEADER,
            "uint8 type",
        ),
    ),
    "irobot_create_msgs/msg/HazardDetectionVector": ((HEADER, "irobot_create_msgs/HazardDetection[] detections"),),
    "irobot_create_msgs/msg/WheelStatus": (
        (
            HEADER,
            "int16 current_ma_left",
            "int16 current_ma_right",
            "int16 pwm_left",
            "int16 pwm_right",
            "bool wheels_enabled",
        ),
    ),
    "irobot_create_msgs/action/LedAnimation": (
        (
            "int8 BLINK_LIGHTS=1",
            "int8 SPIN_LIGHTS=2",
            "int8 animation_type",
            "irobot_create_msgs/LightringLeds lightring",
            "builtin_interfaces/Duration max_runtime",
        ),
        ("builtin_interfaces/Duration runtime",),
        ("builtin_interfaces/Duration remaining_runtime",),
    ),
    "irobot_create_msgs/action/Dock": ((), ("bool is_docked",), ("bool sees_dock",)),
    "irobot_create_msgs/action/Undock": ((), ("bool is_docked",), ()),
    "irobot_create_msgs/srv/EStop": (("bool e_stop_on",), ("bool success", "string message")),
}

TF2 = {"tf2_msgs/msg/TFMessage": (("geometry_msgs/TransformStamped[] transforms",),)}

JOINT_ERROR = ("float64 position", "float64 velocity", "float64 acceleration")

CONTROL = {
    "control_msgs/msg/GripperCommand": (("float64 position", "float64 max_effort"),),
    "control_msgs/msg/JointTolerance": (("string name", *JOINT_ERROR),),
    "control_msgs/msg/JointComponentTolerance": (
        (
            "uint16 X_AXIS=1",
            "uint16 Y_AXIS=2",
            "uint16 Z_AXIS=3",
            "uint16 TRANSLATION=4",
            "uint16 ROTATION=5",
            "string joint_name",
            "uint16 component",
            *JOINT_ERROR,
        ),
    ),
    "control_msgs/action/FollowJointTrajectory": (
        (
            "trajectory_msgs/JointTrajectory trajectory",
            "trajectory_msgs/MultiDOFJointTrajectory multi_dof_trajectory",
            "control_msgs/JointTolerance[] path_tolerance",
            "control_msgs/JointComponentTolerance[] component_path_tolerance",
            "control_msgs/JointTolerance[] goal_tolerance",
            "control_msgs/JointComponentTolerance[] component_goal_tolerance",
            "builtin_interfaces/Duration goal_time_tolerance",
        ),
        (
            "int32 SUCCESSFUL=0",
            "int32 INVALID_GOAL=-1",
            "int32 INVALID_JOINTS=-2",
            "int32 OLD_HEADER_TIMESTAMP=-3",
            "int32 PATH_TOLERANCE_VIOLATED=-4",
            "int32 GOAL_TOLERANCE_VIOLATED=-5",
            "int32 error_code",
            "string error_string",
        ),
        (
            HEADER,
            "string[] joint_names",
            "trajectory_msgs/JointTrajectoryPoint desired",
            "trajectory_msgs/JointTrajectoryPoint actual",
            "trajectory_msgs/JointTrajectoryPoint error",
            "string[] multi_dof_joint_names",
            "trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_desired",
            "trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_actual",
            "trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_error",
        ),
    ),
    "control_msgs/action/GripperCommand": (
        ("control_msgs/GripperCommand command",),
        ("float64 position", "float64 effort", "bool stalled", "bool reached_goal"),
        ("float64 position", "float64 effort", "bool stalled", "bool reached_goal"),
    ),
}

INTERFACES: dict[str, tuple[tuple[str, ...], ...]] = NAV2 | CREATE3 | TF2 | CONTROL
