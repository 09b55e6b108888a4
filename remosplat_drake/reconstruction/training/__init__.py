"""Training of a splat's discs on images; the only part that needs torch."""
