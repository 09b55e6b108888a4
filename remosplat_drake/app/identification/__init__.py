"""How a real robot's axes follow their commands: measured, fitted, written.

`excitation` says which commands tell it, `velocity_run` drives them,
`reading` tells what the drivers answered, `fit` finds the model that explains
that, and `record` writes it into the robot's description.
"""
