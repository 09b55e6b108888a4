"""Assembles the quadratic program of a tick from the ingredients, compiled."""
