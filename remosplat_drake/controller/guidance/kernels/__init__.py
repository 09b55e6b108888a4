"""Simulation of the closed control loop in compiled steps."""
