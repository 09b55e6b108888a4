"""A robot that is not there: simulated drivers, and all that may fail."""
