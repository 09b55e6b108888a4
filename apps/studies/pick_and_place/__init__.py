"""Picks and places random objects, and counts what fails."""
