"""Three votes on one frame, what they rest on, and what they come to."""
