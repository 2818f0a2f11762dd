"""Where to stand and what was looked at: visibility on the grid, viewpoints, the lawnmower, the share explored."""
