"""Serves the page during a run: its files and its newest content."""
