"""Simulated stations: robots with the same ports as the hardware.

`MakeSimulatedStation` builds one of two diagrams. In a `KinematicStation`, the
robot reaches commanded velocities at once, as in the paper; the system
`KinematicRobot` represents it. A `DynamicStation` has rigid bodies, motors with
torque limits, and contact. In it, `VelocityDriver` computes the commands of the
motors (`motors`), `StateReader` outputs the measurements, and `ContactMonitor`
reports contacts.

Both diagrams have the ports of `signals.station_ports`, like the station of a
real robot in `hardware`. So a controller works with each of these stations. The
module `commands` checks the inputs, and `connections` connects the ports with
the vectors q and u.
"""
