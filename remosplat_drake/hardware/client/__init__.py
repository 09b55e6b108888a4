"""Our end of the wire: the real robot behind the ports of every station.

`HardwareStation` is the diagram, and `RemoteRobot` the system in it. Packets
arrive in the `Mailbox`es of a `RobotLink`; `measurement` makes a `Measurement`
of them, `stream` watches each channel's stamps, and `status_monitor` says
whether the robot is there and may move.
"""
