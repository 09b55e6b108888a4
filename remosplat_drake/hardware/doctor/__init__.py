"""Checks the requirements for moving a real robot, step by step.

The result of a check is a `Finding`: the found value and its source, the
expected value, and how to correct it. `host_checks` examine this computer, and
`wire_checks` the packets of the robot's LCM network and their senders'
addresses. `drills` need a person, or motion of the base. `run --hardware`
requires a `DoctorReport` with these findings.
"""
