"""One world to play in: the whole mesh in one process over a simulated home, on a simulated clock, without ROS."""
