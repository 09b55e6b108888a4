"""Captures of scenes that are known, rendered instead of taken."""
