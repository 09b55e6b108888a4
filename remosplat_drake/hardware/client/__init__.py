"""The controller's side of the LCM network: a station for a real robot.

`HardwareStation` is the diagram, and `RemoteRobot` the system in it. Packets
arrive in the `Mailbox`es of a `RobotLink`, and `measurement` converts them to a
`Measurement`. `stream` checks each channel's stamps, and `status_monitor`
decides whether the robot is connected and may move.
"""
