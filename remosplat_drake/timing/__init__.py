"""Benchmarks of ticks, distance queries and rollouts on this machine."""
