"""The parts of `bench.ui`, each a process of its own."""
