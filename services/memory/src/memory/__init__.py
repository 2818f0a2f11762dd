"""Remembers from where things were seen, and tells where to look first."""
