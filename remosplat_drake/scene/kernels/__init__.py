"""Compiled distances to solids and movers."""
