"""The reactive controller: solves a quadratic program at each tick."""
