"""Scenes drawn at random, splats on their solids, and goals within reach."""
