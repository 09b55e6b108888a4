"""Compiled inner loops of the distance oracles, which work on plain arrays.

Tests compare each kernel with a slow, readable reference.
"""
