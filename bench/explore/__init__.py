"""How well an unknown home is explored: by a sensible model, the frontiers, the laser alone, and a hostile model."""
