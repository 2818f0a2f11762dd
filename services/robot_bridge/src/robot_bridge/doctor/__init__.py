"""The doctor: looks at a live ROS graph, and says what fits, what does not, and what to set."""
