"""The simulated robot and its home."""
