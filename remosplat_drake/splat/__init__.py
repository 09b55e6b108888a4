"""Gaussian splats: arrays, file formats and a bounding volume hierarchy."""
