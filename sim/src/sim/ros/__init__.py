"""The simulated robot on ROS 2: the only part of the simulation that needs ROS."""
