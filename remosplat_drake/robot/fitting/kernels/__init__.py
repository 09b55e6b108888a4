"""Compiled kernels of the fits to meshes."""
