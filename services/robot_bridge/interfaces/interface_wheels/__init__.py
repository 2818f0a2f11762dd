"""Builds the ROS 2 interface packages beside this one into wheels, once per source, Python and platform."""
