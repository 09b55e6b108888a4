"""Compares controllers in many scenes: trials, metrics, tables."""
