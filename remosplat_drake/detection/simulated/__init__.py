"""Simulated depth cameras for the detection of movers in simulations."""
