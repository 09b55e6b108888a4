"""How a real robot's axes follow their commands: measured, fitted, written.

`excitation` says which commands tell it, `drive` sends them with a guard,
`fit` finds the model that explains what came of them, and `record` writes it
into the robot's description.
"""
