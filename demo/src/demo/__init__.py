"""Starts the whole mesh with the simulated robot on one machine, sends a command and tells what happens."""
