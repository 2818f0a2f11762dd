"""The parts of `bench.stop`: the rig, and what it starts, each a process of its own."""
