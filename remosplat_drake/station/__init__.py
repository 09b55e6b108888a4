"""Simulated stations: robots with the same ports as the hardware.

`MakeSimulatedStation` builds one of two diagrams. In a `KinematicStation`, the
robot reaches commanded velocities at once, as in the paper; one system,
`KinematicRobot`, represents it. A `DynamicStation` has rigid bodies, motors
with torque limits and contact: `VelocityDriver` computes the commands of the
motors (`motors`), `StateReader` measures, `ContactMonitor` reports contacts.

Both have the ports of `signals.station_ports`, like the real robot's station in
`hardware`, so a controller works with each of them. `commands` checks inputs,
`connections` combines the ports to the vectors q and u.
"""
