"""A robot that is not there: simulated devices with the drivers' own rules.

`HardwareSim` runs `SimulatedPanda`, `SimulatedHand` and `SimulatedBase` on the
rigid bodies of a `RobotPlant`, a millisecond a step, behind the same LCM
messages as the real robot. In the simulated driver's place an `FciArm` obeys
the real one, which reaches it by `fci_library`. `faults` breaks the robot on a
schedule or on request, and `TrueMotion` writes down what it truly did.
"""
