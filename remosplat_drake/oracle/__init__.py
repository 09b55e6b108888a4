"""Distance oracles: how far each robot sphere is from the scene."""
