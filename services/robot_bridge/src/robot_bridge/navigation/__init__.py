"""Where the robot goes: goals and their states, path checks, docking, the map and the place of the dock."""
