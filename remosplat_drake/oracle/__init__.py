"""Distance oracles: distances from the robot's spheres to the scene."""
