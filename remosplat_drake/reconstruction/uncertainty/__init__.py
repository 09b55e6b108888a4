"""Bounds the errors of a splat's discs, and closes gaps between discs."""
