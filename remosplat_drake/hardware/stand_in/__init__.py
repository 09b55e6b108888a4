"""A simulated stand-in for a real robot, with the same LCM messages.

`HardwareSim` runs `SimulatedPanda`, `SimulatedHand` and `SimulatedBase`, which
have the rules of the real drivers, on the rigid bodies of a `RobotPlant`, in
steps of a millisecond. To test the real driver of an arm, an `FciArm` replaces
the simulated driver; the real driver connects to it by `fci_library`. `faults`
simulates faults of the robot, on a schedule or on request, and `TrueMotion`
records its true motion.
"""
