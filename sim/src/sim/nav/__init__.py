"""A stand-in for Nav2: planner, follower and navigator as a pure core. With a real robot, run Nav2 instead."""
