"""The recipe of the simulated home's weights: data set, detector, small CLIP, scores."""
