"""Studies of the system, to be run from a checkout; see README.md."""
