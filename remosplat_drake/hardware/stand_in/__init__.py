"""A simulated stand-in for a real robot, with the same LCM messages.

`HardwareSim` runs `SimulatedPanda`, `SimulatedHand` and `SimulatedBase` in
steps of a millisecond. They follow the rules of the real drivers, and move the
rigid bodies of a `RobotPlant`. To test the real driver of an arm, an `FciArm`
replaces the simulated driver, and the real driver connects to it by
`fci_library`. `faults` simulates faults of the robot, on a schedule or on
request. `TrueMotion` records the robot's true motion.
"""
