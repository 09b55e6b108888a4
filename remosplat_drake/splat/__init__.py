"""Gaussian splats: the scene as arrays, its files and its hierarchy."""
