"""Writes the page as one compressed file, with player and measurements."""
