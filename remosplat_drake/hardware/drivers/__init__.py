"""Driver processes: between the wire and a robot.

Arm: `PandaDriver` serves the wire, by the rules of `panda_commands`, and a
`CallbackProcess` beside it the robot. There a `VelocityCallback` answers every
state through a `VelocityServo`; its `JointInterpolator` is Ruckig's, its last
line is drawn by `panda_limits`, and `SharedRecord`s connect the two processes.
Gripper: `HandDriver` with `PandaPythonHand`. Mobile base: `RosBase` with
`Ros1Link` (rospy) or `Ros2Link` (CycloneDDS); `base_commands` has the watchdog,
`ros_conversion` turns Twist and Odometry messages into the wire's.
"""
