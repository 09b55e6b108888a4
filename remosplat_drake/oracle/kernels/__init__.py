"""The inner loops of the distance oracles, compiled: arrays in, arrays out.

Each has a slow, readable twin with which the tests compare it.
"""
