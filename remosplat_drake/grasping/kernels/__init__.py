"""Kernels of grasping."""
