"""Predicts the robot's state when a command takes effect.

Measurements arrive with latency, and commands act with delay. `History` stores
the commands, and the errors of the actuator model relative to measurements.
`predict` propagates a measurement through the commands.
"""
