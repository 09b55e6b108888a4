"""Simulates the control loop by compiled kernels."""
