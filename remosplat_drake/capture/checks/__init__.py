"""Checks the plausibility of a capture's poses, scale and clocks."""
