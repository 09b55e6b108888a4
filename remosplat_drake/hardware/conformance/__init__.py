"""Checks that a robot's drivers conform to the LCM protocol.

`robot_record` collects LCM packets in a `RobotRecord`. `checks` evaluates this
record, and `following` compares the motion of the axes with their commands.
This package sends no commands: another process, with verification and
supervisor, moves the robot.
"""
