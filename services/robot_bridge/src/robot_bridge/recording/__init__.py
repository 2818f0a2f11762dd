"""Recordings of a mission's topics, in MCAP files."""
