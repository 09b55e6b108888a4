"""Compiled functions of the control tick."""
