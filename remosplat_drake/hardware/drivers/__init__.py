"""Driver processes: between the wire and a robot.

Arm: `PandaDriver` with `PandaPythonArm`; `panda_commands` has its rules and
`panda_limits` libfranka's rate limiter. Gripper: `HandDriver` with
`PandaPythonHand`. Mobile base: `RosBase` with `Ros1Link` (rospy) or `Ros2Link`
(CycloneDDS); `base_commands` has the watchdog, `ros_conversion` turns Twist
and Odometry messages into the wire's.
"""
