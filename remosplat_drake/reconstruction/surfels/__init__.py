"""Surfels from depth images: gathered, thinned and refined without a GPU."""
