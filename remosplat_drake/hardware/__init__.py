"""Real robots, connected by LCM messages; and a simulated stand-in for them.

    station's ports -- client -- wire ~~ LCM ~~ wire -- drivers -- robot
                                                      or stand_in

- `wire`: what both ends agree on. Channel names, encoding and decoding of
  Drake's `lcmt_panda_*` messages and of our own, stamps and their expiry.
- `client`: our end, in the control process. `HardwareStation` is a diagram
  with the ports of every station; `RobotLink` sends commands and hears
  statuses; a status that is stale, frozen or broken stops the robot.
- `drivers`: the far end, one process for each device. `PandaDriver` for the
  arm (libfranka through panda-python), `HandDriver` for its gripper, `RosBase`
  for a base with `cmd_vel` and `odom` (ROS 1 or ROS 2). They clamp velocity
  commands, and stop the robot by a watchdog when none comes.
- `stand_in`: the same far end on a simulated robot, with faults on request:
  what `remosplat hardware-sim` runs.

`HardwareConfig` is the `hardware` section of a scenario: the LCM URL, channel
names, expiry times and speed limits.
"""
