"""What no motion passes by: collision monitor, emergency stop, the base's own stop, what stands round the robot."""
