"""The fast inner loops of the oracles: arrays in, arrays out.

Each has a slow, readable twin, which the tests hold it to.
"""
