"""The shell round the core: runs one mission at a time, moves the robot, tells the others."""
