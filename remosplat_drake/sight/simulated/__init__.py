"""Simulated depth cameras of things that move, fast enough for studies."""
