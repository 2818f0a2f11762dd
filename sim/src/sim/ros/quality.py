"""Quality of service as a TurtleBot 4 on Jazzy has it."""

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

REPUBLISHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""Reliable, the last one kept: all that create3_republisher passes on from the base. Also `map` and `amcl_pose`."""
DRIVER = QoSProfile(depth=10)
"""Reliable: the lidar's driver, image_transport."""
COMMAND = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
"""What create3_republisher listens with."""
