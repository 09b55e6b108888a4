"""Checks that a robot's drivers conform to the LCM protocol.

`robot_record` collects LCM packets in a `RobotRecord`; `checks` evaluates it,
and `following` measures how the axes follow their commands. This package sends
no commands: another run, with verification and supervisor, moves the robot.
"""
