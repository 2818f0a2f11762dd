"""How well the robot finds things, measured with its own eyes: seeded episodes in-process on a simulated clock."""
