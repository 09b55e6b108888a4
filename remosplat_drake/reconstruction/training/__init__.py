"""Training of a splat's discs on images; only this folder needs torch."""
