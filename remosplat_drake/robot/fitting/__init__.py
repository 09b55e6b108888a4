"""Fits spheres and convex pieces that enclose a robot's meshes."""
