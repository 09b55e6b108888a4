"""Error bounds of a splat's discs, and gaps between discs."""
