"""Distances to splats on a CUDA device, in batches, equal to the CPU's."""
