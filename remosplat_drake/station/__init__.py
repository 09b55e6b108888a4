"""Simulated stations: a robot behind the ports of every station.

`MakeSimulatedStation` builds one of two diagrams. `KinematicStation` reaches
commanded velocities at once, as in the paper; its robot is one system,
`KinematicRobot`. `DynamicStation` has rigid bodies, motors with torque limits
and contact: `VelocityDriver` turns commands into the motors' (`motors`),
`StateReader` measures, `ContactMonitor` reports contacts.

Both have the ports of `signals.station_ports`, which `hardware` has, too: a
controller cannot tell a simulated station from the real robot. `commands`
checks what comes in, `connections` joins the ports to the vectors q and u.
"""
