"""Benchmarks of ticks, queries and look-ahead on this machine."""
