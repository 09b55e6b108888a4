"""Connects real robots by LCM messages, and simulates a stand-in for them.

    station's ports -- client -- wire ~~ LCM ~~ wire -- drivers -- robot
                                                      or stand_in

- `wire`: the LCM protocol. It defines the names of channels, encodes and
  decodes Drake's `lcmt_panda_*` messages and the package's own messages, and
  checks whether stamps have expired.
- `client`: the control process. `HardwareStation` is a diagram with the ports
  of every station; `RobotLink` sends commands and receives statuses. A status
  that is stale, frozen or malformed stops the robot.
- `drivers`: one process for each device. `PandaDriver` for the arm (libfranka
  through panda-python), `HandDriver` for its gripper, `BaseDriver` for a base
  with `cmd_vel` and `odom` (ROS 1 or ROS 2). They clamp velocity commands, and
  stop the robot by a watchdog if no command comes.
- `stand_in`: drivers of a simulated robot, with faults on request, which
  `remosplat hardware-sim` runs.

`HardwareConfig` is the `hardware` section of a scenario, with the LCM URL,
channel names, expiry times and speed limits.
"""
