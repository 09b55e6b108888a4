"""The quadratic program of a tick: its parts, and its solvers."""
