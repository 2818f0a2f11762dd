"""A command as it was understood, and the missions that wait for their turn."""
