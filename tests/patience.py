"""How long tests wait for what other processes do."""

PATIENCE = 800.0
"""Longest wait for anything, however busy the computer is [s]."""
