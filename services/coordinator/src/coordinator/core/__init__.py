"""The mission core: `step(mission, event, now_s) -> (mission, actions)`, without I/O, clock or randomness."""
