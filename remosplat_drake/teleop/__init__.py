"""Teleoperation: what an operator asks for, and the target's motion to it."""
