"""Predicts the robot's state at the time at which a command takes effect.

Measurements arrive with latency, and commands act with delay. `History` stores
the commands, and the errors of the actuator model compared with measurements.
`predict` computes the motion that the commands cause after a measurement.
"""
