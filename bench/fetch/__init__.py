"""Fetches played: the manipulation core and the planned grasps on the simulated robot's arm, by physics alone."""
