"""Compiled parts of verification."""
