"""Distances to splats on a CUDA device: the CPU's answers, in batches."""
