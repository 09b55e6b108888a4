"""The quadratic program of a control tick: its terms and its solvers."""
