"""Computes distances to splats on a CUDA device, like the CPU's fields."""
