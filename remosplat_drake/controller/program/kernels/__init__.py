"""Compiled functions of the quadratic program."""
