"""Assembles the ingredients into the program of a tick."""
