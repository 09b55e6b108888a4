"""Injects faults into a robot on an LCM network, and judges its stops."""
