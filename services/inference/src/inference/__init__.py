"""Sees and reads: detector, image-text model, three votes, task parsing."""
