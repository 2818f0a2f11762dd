"""Grasps: where the jaw may stand round a thing, what the arm reaches, and where the robot may stand for it."""
