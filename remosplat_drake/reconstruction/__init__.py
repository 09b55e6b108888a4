"""Reconstruction of a Gaussian splat from posed RGB-D images."""
