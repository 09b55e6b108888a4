"""Checks whether the requirements for moving a real robot are met.

The result of a check is a `Finding`: the found value and its source, the
expected value, and advice to correct it. `host_checks` examines this computer.
`wire_checks` examines the packets of the robot's LCM network and the addresses
of their senders. The checks of `drills` need a person, or motion of the base.
`run --hardware` requires a `DoctorReport` with these findings.
"""
