"""Simulated depth cameras to detect movers, fast enough for studies."""
