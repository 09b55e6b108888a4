"""Surfels from depth images: gathered, thinned, refined."""
