"""Compiled inner loops of verification."""
