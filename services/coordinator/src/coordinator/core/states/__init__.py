"""What the robot does in each state of a mission: one module a state, one table of them (`table`)."""
