"""Compiled inner loops of planning."""
