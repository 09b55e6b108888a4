"""Time limits of tests that wait for other processes."""

PATIENCE = 800.0
"""Longest wait for anything, however busy the computer is [s]."""
