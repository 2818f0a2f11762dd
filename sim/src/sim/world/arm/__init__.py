"""An arm on the robot's deck: its model from a wheel, its place on the robot, its controllers."""
