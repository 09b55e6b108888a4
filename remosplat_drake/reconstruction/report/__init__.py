"""Reports on the reliability of a splat, with measurements and pictures."""
