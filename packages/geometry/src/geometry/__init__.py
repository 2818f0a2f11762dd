"""Planar poses, the occupancy grid and the likeness of two maps: one reading of them for every service."""
