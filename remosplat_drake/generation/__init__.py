"""Generates random scenes, splats on their solids, and reachable goals."""
