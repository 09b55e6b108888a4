"""Converts a robot's files (URDF, SDFormat, MJCF) to a robot description."""
