"""Predicts the robot's state when a command takes effect.

Measurements are old when they come, and commands act late. `History` keeps
what was commanded and how well the model of the actuators explains the
measurements; `predict` leads a measurement forward along it.
"""
