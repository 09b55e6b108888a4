"""Identifies models of a real robot's axes from their motions.

`excitation` chooses commands, `velocity_run` drives them, `reading` reads the
answers of the drivers, `fit` finds the model that explains these, and `record`
writes it into the robot's description.
"""
