"""The quadratic program of a tick: what it is made of, and who solves it."""
