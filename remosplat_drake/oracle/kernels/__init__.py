"""The compiled inner loops of the distance oracles, on plain arrays.

Tests compare each with a slow, readable reference.
"""
