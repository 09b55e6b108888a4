"""Distance oracles, which measure distances from robot spheres to the scene."""
