"""Simulated stations: a robot behind the ports of every station.

`MakeSimulatedStation` builds one of two diagrams. `KinematicStation` reaches
commanded velocities at once, as in the paper; its robot is one system,
`KinematicRobot`. `DynamicStation` has rigid bodies, motors with torque limits
and contact: `VelocityDriver` turns commands into the motors' (`motors`),
`StateReader` measures, `ContactMonitor` reports contacts.

Both have the ports of `signals.station_ports`, as `hardware` does: to a
controller, a simulated station and the real robot are the same. `commands`
checks inputs, `connections` joins the ports to the vectors q and u.
"""
