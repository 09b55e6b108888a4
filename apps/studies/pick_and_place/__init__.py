"""Picks and places random objects, and counts the causes of failures."""
