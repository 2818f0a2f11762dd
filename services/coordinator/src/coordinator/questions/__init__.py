"""Answers to questions, from memory, the missions and the robot's state."""
