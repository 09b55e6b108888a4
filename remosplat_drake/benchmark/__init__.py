"""Compares controllers in many scenes: runs trials, makes tables."""
