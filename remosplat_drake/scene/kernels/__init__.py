"""Compiled distances to known solids."""
