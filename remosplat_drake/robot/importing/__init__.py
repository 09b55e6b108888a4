"""Conversion of a robot's own files into a robot description."""
