"""Distances of convex shapes, compiled."""
