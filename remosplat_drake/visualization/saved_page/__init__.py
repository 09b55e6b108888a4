"""Writes the page as one compressed file, with a player and measurements."""
