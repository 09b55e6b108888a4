"""Injects faults into a robot on a wire, and judges how it stops."""
