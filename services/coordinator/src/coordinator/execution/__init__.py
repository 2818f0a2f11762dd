"""The shell round the core: runs a mission, moves the robot, tells the others."""
