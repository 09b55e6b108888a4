"""Checks whether a capture's poses, scale and clocks can be right."""
