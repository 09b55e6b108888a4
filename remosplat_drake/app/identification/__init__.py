"""Identifies a real robot's axes: excites, reads, fits and writes them.

`excitation` says which commands tell it, `velocity_run` drives them,
`reading` tells what the drivers answered, `fit` finds the model that explains
that, and `record` writes it into the robot's description.
"""
