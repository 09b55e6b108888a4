"""The reactive controller: one quadratic program a tick."""
