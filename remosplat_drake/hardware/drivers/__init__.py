"""Driver processes, which connect a robot's devices to LCM.

Arm: `PandaDriver` exchanges LCM messages, by the rules of `panda_commands`. A
`CallbackProcess` controls the robot: there, a `VelocityCallback` answers every
state of the robot with the command of a `VelocityServo`. The servo smooths
commands by a `JointInterpolator` (Ruckig), and checks them against
`panda_limits`. `SharedRecord`s connect the two processes. Gripper: `HandDriver`
with `PandaPythonHand`. Mobile base: `BaseDriver` with `Ros1Link` (rospy) or
`Ros2Link` (CycloneDDS); `base_commands` has the watchdog, and `ros_conversion`
converts between messages of ROS and of LCM.
"""
