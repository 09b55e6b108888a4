"""Checks that a robot's drivers keep the rules of the wire.

The `Packet`s of a wire become a `RobotRecord`; `checks` judge it, and
`following` how the axes follow. Nothing here sends anything: what moves the
robot has been through verification and supervisor.
"""
