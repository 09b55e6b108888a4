"""Detects moving objects in depth images; the results are `Movers`."""
