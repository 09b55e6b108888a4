"""Checks the requirements for moving a real robot, step by step.

A check ends in a `Finding`: what was found and in which source, what is
wanted, and how to mend it. `host_checks` ask this computer, `wire_checks` the
packets of the robot's wire and their senders' addresses, and `drills` people
and the moving base. The `DoctorReport` of all findings is what `run --hardware`
asks for.
"""
