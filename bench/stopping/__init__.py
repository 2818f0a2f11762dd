"""The parts of `bench.stop`, each a process of its own."""
