"""Identifies models of a real robot's axes from their motions.

`excitation` chooses the commands, and `app/velocity_run.py` sends them to the
robot. `reading` reads the drivers' statuses, `fit` fits a model of each axis to
the measured motion, and `record` writes the models into the robot's description
file.
"""
